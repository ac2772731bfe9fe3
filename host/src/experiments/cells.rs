//! The cells of a study: results that are kept as soon as they are known.
//!
//! `study.json` says what the folder is for; a folder of another study is refused, nothing in it is touched. More seeds, or fewer,
//! are the same study: what is known of a seed is kept.

use super::Request;
use crate::error::Failure;
use crate::store::output::{Output, OutputError};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Name of the resolved configuration.
pub const REQUEST: &str = "study.json";

/// The folder of a study.
#[derive(Debug)]
pub struct Cells<'a> {
    pub output: &'a Output,
}

impl<'a> Cells<'a> {
    /// Begins or goes on.
    ///
    /// # Errors
    ///
    /// A folder that belongs to another study, or cannot be used.
    pub fn open(output: &'a Output, request: &Request) -> Result<Self, Failure> {
        let path = output.path(REQUEST);
        if path.exists() {
            let there: Request = output.read_json(REQUEST, "a study writes it")?;
            if (Request { seeds: request.seeds, ..there.clone() }) != *request {
                let reason = format!(
                    "this folder holds the study {} (from seed {}) with other settings: use the same, or another --out",
                    there.study, there.seed
                );
                return Err(OutputError::Content { path, reason }.into());
            }
            if there.seeds != request.seeds {
                output.write_json(REQUEST, request)?;
            }
        } else {
            output.write_json(REQUEST, request)?;
            output.write("scenario.toml", request.scenario.to_toml().as_bytes())?;
        }
        Ok(Cells { output })
    }

    /// The result kept under `name`, or what `make` finds, kept from now on.
    ///
    /// # Errors
    ///
    /// What `make` says; a result that cannot be kept or read again.
    pub fn get<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        make: impl FnOnce() -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let file = format!("cells/{name}.json");
        if self.output.path(&file).exists() {
            return Ok(self.output.read_json(&file, "remove it to have it made again")?);
        }
        let found = make()?;
        self.output.write_json(&file, &found)?;
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;

    #[test]
    fn cells_are_made_once_and_folders_belong_to_one_study() {
        let folder = tempfile::tempdir().unwrap();
        let output = Output::create(folder.path()).unwrap();
        let request = Request { study: "test".into(), seed: 1, seeds: 2, scenario: Scenario::default() };
        let cells = Cells::open(&output, &request).unwrap();
        assert_eq!(cells.get("a", || Ok(0.1_f64)).unwrap(), 0.1);
        let more = Request { seeds: 3, ..request.clone() };
        let again = Cells::open(&output, &more).unwrap();
        assert_eq!(again.get("a", || -> Result<f64, Failure> { panic!("made twice") }).unwrap(), 0.1);
        assert_eq!(output.read_json::<Request>(REQUEST, "").unwrap(), more);
        let other = Request { seed: 2, ..request };
        let error = Cells::open(&output, &other).unwrap_err().to_string();
        assert!(error.contains("study.json") && error.contains("--out"), "{error}");
    }
}
