//! Any numbers are a plan or refused; any sequence of slots and restarts keeps the plan's shares.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sdp3_core::scheduler::{Plan, Sequencer, SlotUse, USERS, apportion};
use sdp3_fuzz::Bytes;

/// A legal plan of at most 200 slots.
fn plan(bytes: &mut Bytes<'_>) -> Plan {
    let period = 1 + u32::from(bytes.u8()) % 200;
    let spacing = u32::from(bytes.u8()) % 6;
    let sensing = u32::from(bytes.u8()) % (period / (spacing + 1) + 1);
    let rates: Vec<u32> =
        (0..1 + usize::from(bytes.u8()) % USERS).map(|_| 1 + bytes.u32() % (1 << 28)).collect();
    let mut shares = vec![0; rates.len()];
    apportion(&rates, &vec![0; rates.len()], period - sensing, &mut shares);
    assert_eq!(shares.iter().sum::<u32>(), period - sensing);
    Plan::new(period, spacing, sensing, &shares).expect("it adds up")
}

fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let shares: Vec<u32> = (0..bytes.u8() % 10).map(|_| bytes.u32()).collect();
    let (period, spacing, sensing) = (bytes.u32(), bytes.u32(), bytes.u32());
    if let Ok(plan) = Plan::new(period, spacing, sensing, &shares) {
        let mut sequencer = Sequencer::new(&plan);
        (0..64).for_each(|_| {
            sequencer.next_slot();
        });
    }
    let mut current = plan(&mut bytes);
    let mut sequencer = Sequencer::new(&current);
    let (mut sensed, mut served) = (0, [0_u32; USERS]);
    while !bytes.is_empty() {
        let event = bytes.u8();
        if event < 4 {
            let next = (event < 2).then(|| plan(&mut bytes));
            sequencer.restart(next.as_ref());
            current = next.unwrap_or(current);
            (sensed, served) = (0, [0; USERS]);
        }
        for _ in 0..event {
            match sequencer.next_slot() {
                SlotUse::Sensing => sensed += 1,
                SlotUse::Communication(k) => served[usize::from(k)] += 1,
                SlotUse::Idle => assert_eq!(current.shares().iter().sum::<u32>(), 0),
            }
            if sequencer.position() == 0 {
                assert_eq!(sensed, current.sensing());
                assert_eq!(&served[..current.shares().len()], current.shares());
                (sensed, served) = (0, [0; USERS]);
            }
        }
    }
});
