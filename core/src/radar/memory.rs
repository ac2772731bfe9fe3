//! All memory of a radar module in one type that a `static` holds: made by the compiler, never on the stack.

use super::{Filled, Report, SLOT_BUFFERS, Totals};
use crate::early_exit::EarlyExit;
use crate::error::Error;
use crate::pipeline::{Pipeline, PipelineBuffers, PipelineMemory, fast_time, shared_kernels};
use crate::scheduler::Plan;
use crate::signal::stft::{NativeStft, Stft};
use crate::supervision::retained::Message;
use core::sync::atomic::AtomicU32;
use heapless::Vec;
use heapless::spsc::{Consumer, Producer, Queue};

/// The samples of one slot, where a DMA may write them: interleaved in-phase and quadrature, or real values.
///
/// It begins at a cache line of 32 bytes, and no other data shares its lines if `VALUES` is a multiple of 16. A DMA that does not
/// see the data cache needs the buffer's lines cleaned before and invalidated after the transfer, and the static that holds the
/// memory in a section that it reaches.
#[derive(Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(C, align(32))]
pub struct SlotBuffer<const VALUES: usize>(pub [i16; VALUES]);

/// All memory of a radar module; [`radar_memory!`](crate::radar_memory) names the type for a [`Shape`](crate::dsn::Shape).
///
/// `VALUES` of a slot buffer; the others as in [`PipelineMemory`].
pub struct RadarMemory<
    const VALUES: usize,
    const REFERENCE: usize,
    const SLOTS: usize,
    const WORKSPACE: usize,
    const I16X8S: usize,
    const WORDS: usize,
    T: Stft + 'static = NativeStft,
> {
    pipeline: PipelineMemory<REFERENCE, SLOTS, WORKSPACE, I16X8S, WORDS>,
    /// The pipeline, once it is made. Not an `Option`, so that the whole memory is zeros and takes no flash.
    made: Vec<Made<T>, 1>,
    buffers: [SlotBuffer<VALUES>; SLOT_BUFFERS],
    free: Queue<&'static mut SlotBuffer<VALUES>, BUFFERS>,
    filled: Queue<Filled<VALUES>, BUFFERS>,
    reports: Queue<Report, REPORTS>,
    plans: Queue<Message<Plan>, 2>,
    totals: Queue<Totals, 2>,
    release: AtomicU32,
}

/// Reports that may wait, and one.
const REPORTS: usize = 9;

/// The [`RadarMemory`] type for a constant [`Shape`](crate::dsn::Shape).
#[macro_export]
macro_rules! radar_memory {
    ($shape:expr) => {
        $crate::radar::RadarMemory<
            { $shape.slot_values() },
            { $shape.radar.reference_len() },
            { $shape.sensing_slots },
            { $shape.workspace_len() },
            { $shape.winograd_sizes().vectors },
            { $shape.winograd_sizes().words },
        >
    };
}

/// Where one context puts values into a queue of size `N`.
///
/// heapless looks up a queue's size when it runs. With the comparison the compiler knows it, and leaves out the division by it and
/// the panic of a division by zero.
pub(super) struct Sender<T: 'static, const N: usize>(Producer<'static, T>);

impl<T, const N: usize> Sender<T, N> {
    /// The value back if the queue is full.
    #[inline]
    pub fn enqueue(&mut self, value: T) -> Result<(), T> {
        if self.0.capacity() + 1 == N { self.0.enqueue(value) } else { Err(value) }
    }

    /// Whether there is room.
    #[inline]
    pub fn ready(&self) -> bool {
        self.0.capacity() + 1 == N && self.0.ready()
    }
}

/// Where the other context takes them out.
pub(super) struct Receiver<T: 'static, const N: usize>(Consumer<'static, T>);

impl<T, const N: usize> Receiver<T, N> {
    /// The oldest value.
    #[inline]
    pub fn dequeue(&mut self) -> Option<T> {
        if self.0.capacity() + 1 == N { self.0.dequeue() } else { None }
    }

    /// A look at it.
    #[inline]
    pub fn peek(&self) -> Option<&T> {
        self.0.peek()
    }

    /// Whether there is one.
    #[inline]
    pub fn ready(&self) -> bool {
        self.0.ready()
    }
}

/// Both ends of a queue.
fn split<T, const N: usize>(queue: &'static mut Queue<T, N>) -> (Sender<T, N>, Receiver<T, N>) {
    let (sender, receiver) = queue.split();
    (Sender(sender), Receiver(receiver))
}

/// Size of the queues of slot buffers: they hold one element less.
const BUFFERS: usize = SLOT_BUFFERS + 1;

/// The slot context's ends of the queues.
pub(super) struct SlotEnds<const VALUES: usize> {
    pub free: Receiver<&'static mut SlotBuffer<VALUES>, BUFFERS>,
    pub filled: Sender<Filled<VALUES>, BUFFERS>,
    pub reports: Sender<Report, REPORTS>,
    pub plans: Receiver<Message<Plan>, 2>,
    pub totals: Receiver<Totals, 2>,
    pub release: &'static AtomicU32,
}

/// The processing context's ends of the queues.
pub(super) struct ProcessingEnds<const VALUES: usize> {
    pub free: Sender<&'static mut SlotBuffer<VALUES>, BUFFERS>,
    pub filled: Receiver<Filled<VALUES>, BUFFERS>,
    pub reports: Receiver<Report, REPORTS>,
    pub plans: Sender<Message<Plan>, 2>,
    pub totals: Sender<Totals, 2>,
    pub release: &'static AtomicU32,
}

/// Where the pipeline is made.
pub(super) struct PipelinePlace<T: Stft + 'static> {
    buffers: PipelineBuffers<'static>,
    made: &'static mut Vec<Made<T>, 1>,
}

pub(super) type Made<T> = Pipeline<'static, 'static, crate::dsn::WinogradKernels<'static>, T>;

impl<T: Stft> PipelinePlace<T> {
    #[inline(never)] // what is moved does not lie under the rest
    pub fn make(
        mut self,
        exits: &[EarlyExit<'static>],
        threshold: f32,
    ) -> Result<&'static mut Made<T>, Error> {
        let full = Error::Memory { buffer: "pipeline", need: 1, have: 0 };
        let kernels = shared_kernels(exits, &mut self.buffers)?;
        let fast_time = fast_time(exits, &mut self.buffers)?;
        let made = self.made.push(Pipeline::assemble(exits, threshold, fast_time, self.buffers, kernels));
        made.map_err(|_| full)?;
        self.made.first_mut().ok_or(full)
    }
}

impl<
    const VALUES: usize,
    const REFERENCE: usize,
    const SLOTS: usize,
    const WORKSPACE: usize,
    const I16X8S: usize,
    const WORDS: usize,
    T: Stft,
> RadarMemory<VALUES, REFERENCE, SLOTS, WORKSPACE, I16X8S, WORDS, T>
{
    /// Bytes of this memory.
    pub const BYTES: usize = size_of::<Self>();

    /// Memory for a `static`.
    #[allow(clippy::new_without_default)] // a default would be made on the stack
    pub const fn new() -> Self {
        RadarMemory {
            pipeline: PipelineMemory::new(),
            made: Vec::new(),
            buffers: [const { SlotBuffer([0; VALUES]) }; SLOT_BUFFERS],
            free: Queue::new(),
            filled: Queue::new(),
            reports: Queue::new(),
            plans: Queue::new(),
            totals: Queue::new(),
            release: AtomicU32::new(0),
        }
    }

    /// The place of the pipeline, and both ends of every queue, with all buffers free.
    pub(super) fn split(&'static mut self) -> (PipelinePlace<T>, (SlotEnds<VALUES>, ProcessingEnds<VALUES>)) {
        let RadarMemory { pipeline, made, buffers, free, filled, reports, plans, totals, release } = self;
        let (mut free_in, free) = split(free);
        for buffer in buffers {
            let _ = free_in.enqueue(buffer); // one place for each
        }
        let (filled_in, filled) = split(filled);
        let (reports_in, reports) = split(reports);
        let (plans_in, plans) = split(plans);
        let (totals_in, totals) = split(totals);
        let slots = SlotEnds { free, filled: filled_in, reports: reports_in, plans, totals, release };
        let processing =
            ProcessingEnds { free: free_in, filled, reports, plans: plans_in, totals: totals_in, release };
        (PipelinePlace { buffers: pipeline.view(), made }, (slots, processing))
    }
}
