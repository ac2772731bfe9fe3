//! Any bytes are a network of another program, .tflite or .safetensors, or refused with words; one that is taken is a model.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sdp3::formats::model_file::Preprocessing;
use sdp3::formats::tflite::{ImportDefaults, import_graph, import_model};
use sdp3::network::safetensors;

fuzz_target!(|data: &[u8]| {
    let Some((&kind, rest)) = data.split_first() else { return };
    if kind % 2 == 0 {
        let preprocessing = Preprocessing {
            radar: sdp3_core::config::RadarConfig::PAPER,
            sensing_slots: 200,
            first_kept: 3,
            last_kept: 8,
            window_len: 128,
            hop: 8,
            bins_per_row: 1,
            range: 1063,
            kaiser_beta: 10.0,
            carrier_khz: 3_500_000,
            slow_time_us: 1000,
        };
        let import_defaults = ImportDefaults { preprocessing, sensing_slots: vec![200], classes: Vec::new() };
        match import_model(rest, &import_defaults) {
            Ok((file, _)) => assert!(sdp3_core::dsn::Model::parse(&file).is_ok()),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
        match import_graph(rest) {
            Ok(graph) => assert!(sdp3_core::graph::Graph::parse(&graph).is_ok()),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    } else {
        match safetensors::read(rest, usize::from(1 + (kind >> 1) % 2)) {
            Ok(parameters) => assert!(safetensors::write(&parameters).is_ok()),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
});
