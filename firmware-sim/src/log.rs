//! defmt frames into a file of the emulator's host, never mixed with the text protocol.
//!
//! Without a file the records are dropped.
#![allow(unsafe_code)]

use crate::rt::Single;
use crate::semihosting::File;
use core::sync::atomic::{AtomicPtr, Ordering};

struct Sink {
    file: Option<File>,
    encoder: defmt::Encoder,
}

static SINK: Single<Sink> = Single::new(Sink { file: None, encoder: defmt::Encoder::new() });
static CURRENT: AtomicPtr<Sink> = AtomicPtr::new(core::ptr::null_mut());

/// Sends all records from now on to this file.
pub fn open(path: &str) -> bool {
    let Some(file) = File::create(path) else { return false };
    let Some(sink) = SINK.take() else { return false };
    sink.file = Some(file);
    CURRENT.store(sink, Ordering::Release);
    true
}

/// The encoder and where its bytes go.
fn with(f: impl FnOnce(&mut defmt::Encoder, &mut File)) {
    let sink = CURRENT.load(Ordering::Acquire);
    // SAFETY: the pointer is null or the one owner's; there is one core and no interrupt handler logs.
    let Some(Sink { file: Some(file), encoder }) = (unsafe { sink.as_mut() }) else { return };
    f(encoder, file);
}

#[defmt::global_logger]
struct Logger;

// SAFETY: one core, no interrupts that log: acquire and release cannot nest.
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        with(|encoder, file| {
            encoder.start_frame(|bytes| {
                file.write(bytes);
            });
        });
    }
    unsafe fn flush() {}
    unsafe fn release() {
        with(|encoder, file| {
            encoder.end_frame(|bytes| {
                file.write(bytes);
            });
        });
    }
    unsafe fn write(bytes: &[u8]) {
        with(|encoder, file| {
            encoder.write(bytes, |bytes| {
                file.write(bytes);
            });
        });
    }
}
