//! Runs the scheduler under churn and prints the digest of its decisions and the instructions they take.
//!
//! Exit code 0 if the digest is the known one, 1 if not.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use rand_core::SeedableRng;
    use sdp3_core::scheduler::{Plan, Sequencer, SlotUse};
    use sdp3_firmware_sim::rt::{instructions, start_counter};
    use sdp3_firmware_sim::semihosting::{exit, println};
    use sdp3_testkit::churn;

    /// Instructions of one decision: a period of the paper's with `shares`, from its first slot to its last.
    fn instructions_per_decision(sensing: u32, shares: &[u32]) -> u64 {
        let Ok(plan) = Plan::new(4000, 3, sensing, shares) else { return 0 };
        let mut sequencer = Sequencer::new(&plan);
        let before = instructions();
        let mut sum = 0_u32;
        for _ in 0..plan.period() {
            if let SlotUse::Communication(k) = sequencer.next_slot() {
                sum = sum.wrapping_add(u32::from(k));
            }
        }
        core::hint::black_box(sum);
        instructions().wrapping_sub(before).checked_div(plan.period().into()).unwrap_or(0)
    }

    /// Most instructions of a period's first decision, which may make a new plan, and of an end of sensing, under churn.
    fn most_instructions() -> [u64; 2] {
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(4);
        let mut churn = churn::Churn::new(&mut rng);
        let mut most = [0; 2];
        for _ in 0..churn::PERIODS {
            churn.between(&mut rng);
            let before = instructions();
            let first = churn.scheduler.next_slot();
            let between = instructions();
            core::hint::black_box(first);
            if churn.scheduler.position() > 0 {
                churn.scheduler.end_sensing();
            }
            let counts = [between.wrapping_sub(before), instructions().wrapping_sub(between)];
            most.iter_mut().zip(counts).for_each(|(most, count)| *most = count.max(*most));
            while churn.scheduler.position() > 0 {
                churn.scheduler.next_slot();
            }
        }
        most
    }

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        start_counter();
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(3);
        let digest = churn::run(&mut rng, churn::PERIODS);
        println(format_args!("digest {:016x} of {}", digest.hash(), digest.count()));
        let three = instructions_per_decision(309, &[1297, 1197, 1197]);
        let eight = instructions_per_decision(400, &[450; 8]);
        println(format_args!("instructions a decision: {three} with 3 users, {eight} with 8"));
        let [plan, end] = most_instructions();
        println(format_args!("instructions of a new plan: at most {plan}, of an end of sensing {end}"));
        let known = digest.hash() == churn::KNOWN_ANSWER;
        println(format_args!("{}", if known { "known" } else { "UNKNOWN" }));
        exit(usize::from(!known))
    }
}
