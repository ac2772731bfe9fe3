//! Text over a serial line, and the conformance suite that prints to it.

use crate::linked;
use core::fmt::{Arguments, Write};
use sdp3_conformance::Machine;

/// A serial line.
pub trait Serial {
    /// Sends a byte; waits until there is room for it.
    fn send(&mut self, byte: u8);
}

struct Text<'s, S>(&'s mut S);

impl<S: Serial> Write for Text<'_, S> {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        text.bytes().for_each(|byte| self.0.send(byte));
        Ok(())
    }
}

/// Writes a line.
pub fn print(serial: &mut impl Serial, line: Arguments<'_>) {
    let mut text = Text(serial);
    let _ = text.write_fmt(line); // `Text` has no errors
    let _ = text.write_str("\n");
}

/// A board with a suite.
pub struct Board<S, C> {
    /// The suite.
    pub suite: &'static [u8],
    /// What is printed goes here.
    pub serial: S,
    /// Cycles so far.
    pub cycles: C,
}

impl<S: Serial, C: FnMut() -> u64> Machine for Board<S, C> {
    fn read(&mut self, at: usize, buffer: &mut [u8]) -> bool {
        let Some(bytes) = self.suite.get(at..at + buffer.len()) else { return false };
        buffer.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
        true
    }
    fn print(&mut self, line: Arguments<'_>) {
        print(&mut self.serial, line);
    }
    fn count(&mut self) -> u64 {
        (self.cycles)()
    }
    fn stack(&mut self) -> usize {
        linked::stack_used()
    }
}
