//! Any text is a scenario or refused; a scenario that is taken is taken again from what it writes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sdp3::scenario::Scenario;
use std::path::Path;

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let origin = Path::new("fuzz.toml");
    match Scenario::parse(text, origin) {
        Ok(scenario) => {
            let again = Scenario::parse(&scenario.to_toml(), origin).expect("a resolved scenario");
            assert_eq!(again.to_toml(), scenario.to_toml());
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
});
