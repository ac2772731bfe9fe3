//! A board's serial line: the standard output of a command.

use super::Result;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Without a line for this long a board counts as silent.
const SILENCE: Duration = Duration::from_secs(120);

/// Ends the command when it goes.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// All lines up to `done` that a command prints.
pub fn lines(command: &[String]) -> Result<String> {
    let (name, arguments) = command.split_first().ok_or("no command")?;
    let started = Command::new(name).args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).spawn();
    let mut running = Running(started.map_err(|error| format!("{name}: {error}"))?);
    let receive = running.0.stdout.take().ok_or("no pipe")?;
    let (send, received) = channel();
    // a read cannot be interrupted: the thread ends with the program
    std::thread::spawn(move || {
        BufReader::new(receive).lines().map_while(std::io::Result::ok).all(|line| send.send(line).is_ok())
    });
    let mut text = String::new();
    loop {
        let line = match received.recv_timeout(SILENCE) {
            Ok(line) => line,
            Err(RecvTimeoutError::Timeout) => {
                return Err(format!("silent for {SILENCE:?} after\n{text}").into());
            }
            Err(RecvTimeoutError::Disconnected) => return Err(format!("the line ended after\n{text}").into()),
        };
        text += &line;
        text.push('\n');
        if line.starts_with("error") {
            return Err(text.into());
        }
        if line == "done" {
            return Ok(text);
        }
    }
}
