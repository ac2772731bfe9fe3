//! Any text is a plan or refused, and a plan's resolved form is the same plan; any file in a cell's place is that cell or refused.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sdp3::experiments::sweep::plan::Sweep;
use sdp3::experiments::sweep::store::Store;
use sdp3_fuzz::files::Folder;

/// One cell: `tests/fuzzing/seeds/sweep/cell` is it, behind a byte 1.
const PLAN: &str = include_str!("../plan.toml");

fuzz_target!(|data: &[u8]| {
    let Some((&kind, rest)) = data.split_first() else { return };
    if kind % 2 == 0 {
        let folder = Folder::new(&[("plan.toml", rest)]);
        match Sweep::load(&folder.path().join("plan.toml"), None, None) {
            Ok(sweep) => {
                assert!(!sweep.cells.is_empty());
                let folder = Folder::new(&[("sweep.toml", sweep.plan.to_toml().as_bytes())]);
                let again =
                    Sweep::load(&folder.path().join("sweep.toml"), None, None).expect("a resolved plan");
                assert_eq!(again.digest, sweep.digest);
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    } else {
        let folder = Folder::new(&[("fixed.toml", PLAN.as_bytes()), ("cells/00000.json", rest)]);
        let sweep = Sweep::load(&folder.path().join("fixed.toml"), None, None).expect("the plan above");
        let (cell, _) = &sweep.cells[0];
        match Store::of(&sweep, folder.path()).read(cell).expect("a file that can be read") {
            Ok(measurement) => assert_eq!(measurement.cell, *cell),
            Err(fault) => assert!(!fault.to_string().is_empty()),
        }
    }
});
