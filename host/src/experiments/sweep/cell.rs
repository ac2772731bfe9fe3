//! One cell, end to end: simulate, train, quantise, recognise through the core, divide the slots left over.

use crate::error::Failure;
use crate::experiments::RunContext;
use crate::experiments::trained::{images, train};
use crate::network::spectrograms::Part;
use crate::optimizer::bits_per_slot;
use crate::optimizer::shares::divide;
use crate::results::{Cell, Measurement, Throughput};
use crate::scenario::Scenario;

/// Measures a cell; its scenario has its carrier, its rho and its N_s alone. The same bits for any number of threads.
///
/// Cost: that of one network of `sdp3 study learning-curve`.
///
/// # Errors
///
/// Whatever the training, the core or the optimizer say.
pub fn measure(cell: &Cell, scenario: &Scenario, context: RunContext) -> Result<Measurement, Failure> {
    let (rho, seed) = (cell.rho, cell.seed);
    let trained = train(scenario, seed, &images(scenario, rho, seed, Part::Train, context), context)?;
    let tested = trained.test(scenario, &images(scenario, rho, seed, Part::Test, context))?;
    let accuracy = tested.into_iter().next().ok_or("a cell has one N_s")?;
    let left = scenario.frame.period_slots - cell.sensing_slots;
    let of_case = |(case, slot_bit): (u32, Vec<f64>)| {
        let (communication_slots, throughput_bit) = divide(&slot_bit, left);
        Throughput { case, slot_bit, communication_slots, throughput_bit }
    };
    let throughput = bits_per_slot(scenario, seed)?.into_iter().map(of_case).collect();
    Ok(Measurement { cell: cell.clone(), accuracy, throughput })
}
