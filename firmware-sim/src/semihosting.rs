//! The emulator's services: arguments, files, text, exit code.
//!
//! Arm semihosting specification; the same operations on RISC-V.

use crate::rt::call;
use core::fmt::{Arguments, Write};

/// An open file.
#[derive(Debug)]
pub struct File {
    handle: usize,
    position: usize,
}

impl File {
    /// Opens a file for reading.
    pub fn open(path: &str) -> Option<File> {
        Self::with_mode(path, 1)
    }

    /// Creates or empties a file for writing.
    pub fn create(path: &str) -> Option<File> {
        Self::with_mode(path, 5)
    }

    fn with_mode(path: &str, mode: usize) -> Option<File> {
        let mut name = [0_u8; 512];
        name.get_mut(..path.len())?.copy_from_slice(path.as_bytes());
        if path.len() >= name.len() {
            return None;
        }
        let handle = call(0x01, &mut [name.as_ptr() as usize, mode, path.len(), 0]);
        (handle >= 0).then_some(File { handle: handle as usize, position: 0 })
    }

    /// Its bytes.
    pub fn length(&self) -> Option<usize> {
        usize::try_from(call(0x0c, &mut [self.handle, 0, 0, 0])).ok()
    }

    /// Fills the buffer; false if the file ends before.
    pub fn read(&mut self, buffer: &mut [u8]) -> bool {
        self.read_at(buffer.as_mut_ptr() as usize, buffer.len())
    }

    /// Fills the buffer with little-endian values, as every machine here has them; false if the file ends before.
    pub fn read_values(&mut self, buffer: &mut [i16]) -> bool {
        self.read_at(buffer.as_mut_ptr() as usize, size_of_val(buffer))
    }

    /// Fills `bytes` bytes of an exclusive slice.
    fn read_at(&mut self, address: usize, bytes: usize) -> bool {
        self.position += bytes;
        bytes == 0 || call(0x06, &mut [self.handle, address, bytes, 0]) == 0
    }

    /// Byte that is read next.
    pub fn position(&self) -> usize {
        self.position
    }

    /// Goes on reading at this byte.
    pub fn seek(&mut self, position: usize) -> bool {
        self.position = position;
        call(0x0a, &mut [self.handle, position, 0, 0]) == 0
    }

    /// Reads a little-endian word.
    pub fn word(&mut self) -> Option<u32> {
        let mut bytes = [0; 4];
        self.read(&mut bytes).then(|| u32::from_le_bytes(bytes))
    }

    /// Writes all bytes.
    pub fn write(&mut self, bytes: &[u8]) -> bool {
        bytes.is_empty() || call(0x05, &mut [self.handle, bytes.as_ptr() as usize, bytes.len(), 0]) == 0
    }
}

/// The content of a file, if the memory holds it.
pub fn file_into<'a>(path: &str, memory: &'a mut [u8]) -> Option<&'a [u8]> {
    let mut file = File::open(path)?;
    let content = memory.get_mut(..file.length()?)?;
    file.read(content).then_some(&*content)
}

/// The emulator's arguments, separated by spaces.
pub fn arguments(buffer: &mut [u8; 1024]) -> &str {
    // the emulator writes the address and length of the text back into the block
    let mut block = [buffer.as_mut_ptr() as usize, buffer.len() - 1, 0, 0];
    if call(0x15, &mut block) != 0 {
        return "";
    }
    let length = buffer.iter().position(|&b| b == 0).unwrap_or(0);
    buffer.get(..length).and_then(|text| core::str::from_utf8(text).ok()).unwrap_or("")
}

/// Prints text.
pub fn print(text: &str) {
    for chunk in text.as_bytes().chunks(127) {
        let mut line = [0_u8; 128];
        line.iter_mut().zip(chunk).for_each(|(to, from)| *to = *from);
        crate::rt::write0(&line);
    }
}

/// Prints a number in decimal.
pub fn print_number(mut value: usize) {
    let mut digits = [0_u8; 20];
    let mut first = digits.len();
    for (at, digit) in digits.iter_mut().enumerate().rev() {
        *digit = b'0' + (value % 10) as u8;
        first = at;
        value /= 10;
        if value == 0 {
            break;
        }
    }
    print(digits.get(first..).and_then(|text| core::str::from_utf8(text).ok()).unwrap_or_default());
}

/// Prints formatted text and a newline.
pub fn println(text: Arguments) {
    struct Out;
    impl Write for Out {
        fn write_str(&mut self, text: &str) -> core::fmt::Result {
            print(text);
            Ok(())
        }
    }
    let _ = Out.write_fmt(text);
    print("\n");
}

/// Ends the emulator with an exit code.
pub fn exit(code: usize) -> ! {
    loop {
        call(0x20, &mut [0x20026, code, 0, 0]);
    }
}
