//! The cells of a study: results that are kept as soon as they are known, each a [`record`] that belongs to the study.
//!
//! `study.json` says what the folder is for; a folder of another study is refused, nothing in it is touched. More seeds, or fewer,
//! are the same study: what is known of a seed is kept. Cells belong to the text of the folder's `scenario.toml`, which an earlier program
//! may have written with fewer fields: it is the study's scenario as long as it describes the same.

use super::Request;
use crate::error::Failure;
use crate::scenario::Scenario;
use crate::store::digest::sha256;
use crate::store::output::Output;
use crate::store::record::{self, Fault, Identity, value};
use crate::store::resume::ensure_same_config;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// Name of the resolved configuration.
pub const REQUEST: &str = "study.json";

/// Whether a text describes this scenario, with the defaults of the fields that it leaves out.
fn describes(text: &[u8], scenario: &Scenario) -> bool {
    let found =
        str::from_utf8(text).ok().and_then(|text| Scenario::parse(text, Path::new(Scenario::FILE)).ok());
    found.as_ref() == Some(scenario)
}

/// The folder of a study.
#[derive(Debug)]
pub struct Cells<'a> {
    pub output: &'a Output,
    study: Identity,
}

impl<'a> Cells<'a> {
    /// Begins or goes on.
    ///
    /// # Errors
    ///
    /// A folder that belongs to another study, or cannot be used.
    pub fn open(output: &'a Output, request: &Request) -> Result<Self, Failure> {
        ensure_same_config(output, REQUEST, &value(request), |text| {
            let there: Request = serde_json::from_str(text).map_err(|error| error.to_string())?;
            Ok(value(&Request { seeds: request.seeds, ..there }))
        })?;
        let mut scenario = request.scenario.to_toml().into_bytes();
        if output.path(REQUEST).exists() {
            let there = output.read(Scenario::FILE, "").ok();
            scenario = there.filter(|text| describes(text, &request.scenario)).unwrap_or(scenario);
        } else {
            output.write(Scenario::FILE, &scenario)?;
        }
        output.write_json(REQUEST, request)?;
        let study = vec![
            ("study", value(&request.study)),
            ("seed", value(&request.seed)),
            ("scenario_sha256", value(&sha256([scenario.as_slice()]))),
        ];
        Ok(Cells { output, study })
    }

    /// The result kept under `name`, or what `make` finds, kept from now on.
    ///
    /// # Errors
    ///
    /// What `make` says; a result that is damaged or of another study, or that cannot be kept.
    pub fn get<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        make: impl FnOnce() -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let file = format!("cells/{name}.json");
        let identity = [&self.study[..], &[("cell", value(&name))]].concat();
        let path = self.output.path(&file);
        match record::read(&path, &identity)? {
            Ok(found) => return Ok(found),
            Err(Fault::Missing) => (),
            Err(fault) => return Err(fault.refusal(&path, "remove it to have it made again").into()),
        }
        let found = make()?;
        record::write(self.output, &file, &identity, &found)?;
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request() -> Request {
        Request { study: "test".into(), seed: 1, seeds: 2, scenario: Scenario::default() }
    }

    fn made_twice() -> Result<f64, Failure> {
        panic!("made twice")
    }

    #[test]
    fn cells_are_made_once_and_folders_belong_to_one_study() {
        let folder = tempfile::tempdir().unwrap();
        let output = Output::create(folder.path()).unwrap();
        let cells = Cells::open(&output, &request()).unwrap();
        assert_eq!(cells.get("a", || Ok(0.1_f64)).unwrap(), 0.1);
        let more = Request { seeds: 3, ..request() };
        let again = Cells::open(&output, &more).unwrap();
        assert_eq!(again.get("a", made_twice).unwrap(), 0.1);
        assert_eq!(output.read_json::<Request>(REQUEST, "").unwrap(), more);
        let error = Cells::open(&output, &Request { seed: 2, ..request() }).unwrap_err().to_string();
        for word in ["study.json", "seed = 1", "says 2", "--out"] {
            assert!(error.contains(word), "{word:?} is not in: {error}");
        }
    }

    #[test]
    fn cells_of_an_earlier_program_that_knew_fewer_fields_belong_to_the_same_study() {
        let folder = tempfile::tempdir().unwrap();
        let output = Output::create(folder.path()).unwrap();
        let text = request().scenario.to_toml();
        let field = "ac_coupling_hz = 0.0\n";
        assert!(text.contains(field));
        let fewer = text.replace(field, "");
        let of_text = |text: &str| vec![("scenario_sha256", value(&sha256([text.as_bytes()])))];
        let mut study = value(&request());
        study["scenario"]["radar"].as_object_mut().unwrap().remove("ac_coupling_hz").unwrap();
        output.write_json(REQUEST, &study).unwrap();
        output.write(Scenario::FILE, fewer.as_bytes()).unwrap();
        let cell = |name: &str| {
            Cells::open(&output, &request()).unwrap().get(name, || Ok(0.25_f64)).unwrap();
            output.path(&format!("cells/{name}.json"))
        };
        let identified = |name: &str, text: &str| record::read::<f64>(&cell(name), &of_text(text)).unwrap();
        assert_eq!(identified("a", &fewer), Ok(0.25));
        // a text of another scenario is not the study's
        output
            .write(
                Scenario::FILE,
                fewer.replace("carrier_hz = 3500000000.0", "carrier_hz = 5800000000.0").as_bytes(),
            )
            .unwrap();
        assert_eq!(identified("b", &text), Ok(0.25));
    }

    #[test]
    fn damaged_and_foreign_cells_are_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let output = Output::create(folder.path()).unwrap();
        let cells = Cells::open(&output, &request()).unwrap();
        cells.get("a", || Ok(0.25_f64)).unwrap();
        let path = output.path("cells/a.json");
        let text = std::fs::read_to_string(&path).unwrap();
        let refused = |name: &str, words: &[&str]| {
            let error = cells.get(name, made_twice).unwrap_err().to_string();
            words.iter().for_each(|word| assert!(error.contains(word), "{word:?} is not in: {error}"));
            assert!(error.contains("remove it to have it made again"), "{error}");
        };
        std::fs::write(&path, text.replace("0.25", "0.75")).unwrap();
        refused("a", &["cells/a.json: damaged: sha256 = "]);
        std::fs::write(&path, &text[..text.len() / 2]).unwrap();
        refused("a", &["cells/a.json: damaged: ", "line"]);
        std::fs::write(&path, &text).unwrap();
        std::fs::copy(&path, output.path("cells/b.json")).unwrap();
        refused("b", &["cells/b.json: foreign: cell is \"a\", must be \"b\""]);
        let elsewhere = tempfile::tempdir().unwrap();
        let output = Output::create(elsewhere.path()).unwrap();
        let other = Cells::open(&output, &Request { study: "other".into(), ..request() }).unwrap();
        other.get("a", || Ok(0.25_f64)).unwrap();
        std::fs::copy(output.path("cells/a.json"), &path).unwrap();
        refused("a", &["cells/a.json: foreign: study is \"other\", must be \"test\""]);
    }
}
