//! `sdp3-defmt ELF LOG`: the defmt records of a log, one a line: level, text. Exit code 2 if a record is malformed.

use defmt_decoder::{DecodeError, Table};
use std::error::Error;
use std::process::ExitCode;

fn print(elf: &str, log: &str) -> Result<(), Box<dyn Error>> {
    let table = Table::parse(&std::fs::read(elf)?)?.ok_or("no defmt table in the ELF file")?;
    let mut decoder = table.new_stream_decoder();
    decoder.received(&std::fs::read(log)?);
    loop {
        match decoder.decode() {
            Ok(frame) => {
                let level = frame.level().map_or("", |level| level.as_str());
                println!("{level} {}", frame.display_message());
            }
            Err(DecodeError::UnexpectedEof) => return Ok(()),
            Err(DecodeError::Malformed) => return Err("a malformed record".into()),
        }
    }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [elf, log] = arguments.as_slice() else {
        eprintln!("usage: sdp3-defmt ELF LOG");
        return ExitCode::from(2);
    };
    match print(elf, log) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("sdp3-defmt: {elf}, {log}: {error}");
            ExitCode::from(2)
        }
    }
}
