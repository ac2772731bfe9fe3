//! The published JSON Schemas are those of the types. With `SDP3_WRITE_SCHEMAS` set they are written again.

use sdp3::schemas::{PUBLISHED, of_types};
use sdp3::store::output::to_json;
use std::path::Path;

#[test]
fn the_published_schemas_are_those_of_the_types() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host/schemas");
    for (name, text) in PUBLISHED {
        let Some(schema) = of_types(name) else {
            assert_eq!(name, "study", "only a build that trains has this type");
            eprintln!("SKIPPED: the schema `study` needs the feature `train`");
            continue;
        };
        if std::env::var_os("SDP3_WRITE_SCHEMAS").is_some() {
            std::fs::write(folder.join(format!("{name}.json")), to_json(&schema) + "\n").expect("a schema");
            continue;
        }
        let published: serde_json::Value = serde_json::from_str(text).expect("JSON");
        assert_eq!(
            published, schema,
            "host/schemas/{name}.json is not the type's: SDP3_WRITE_SCHEMAS=1 writes it"
        );
    }
    let files = std::fs::read_dir(&folder).expect("the schemas").count();
    assert_eq!(files, PUBLISHED.len());
}
