//! The communication side: OFDM links from the base station to users.

use super::Scenario;
use super::rules::Rules;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Most sub-carriers M.
const SUBCARRIERS: u32 = 65_536;

/// The communication side.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Communication {
    /// OFDM sub-carriers M; 0: as many as fit, floor(bandwidth_hz x (symbol_s - prefix_s)).
    pub subcarriers: u32,
    /// Bandwidth that they share in Hz.
    pub bandwidth_hz: f64,
    /// Duration of an OFDM symbol with its prefix T_o in s.
    pub symbol_s: f64,
    /// Cyclic prefix of an OFDM symbol in s, a part of symbol_s.
    pub prefix_s: f64,
    /// Most bits that a sub-carrier carries in a symbol: 8 for 256-QAM; 0: no limit.
    pub modulation_bit: f64,
    /// Error vector magnitude of the transmitter in percent: signal over noise and error is at most -20 log10(EVM / 100) dB; 0: an
    /// ideal transmitter. 3GPP TS 38.104 table 6.5.2.2-1 allows 3.5 for 256-QAM.
    pub evm_percent: f64,
    /// Transmit power in W, shared by the sub-carriers.
    pub power_w: f64,
    /// Noise figure of the users' receivers in dB.
    pub noise_figure_db: f64,
    /// User positions in m, one list per case.
    pub cases: Vec<Vec<[f64; 3]>>,
    /// Channel draws averaged for the expected gain of a sub-carrier.
    pub draws: u32,
    /// Whether the person sensed and everybody else of the scenario are in the users' channels, in every draw at another moment of a
    /// motion of a random class; false: these channels are empty of people.
    pub people: bool,
    /// Bits that one slot carries to every user, one list per case, where links are known; the channel model is not used then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slot_bit: Option<Vec<Vec<f64>>>,
}

impl Communication {
    /// Sub-carriers that fit the bandwidth at the spacing 1 / (symbol_s - prefix_s).
    pub fn most_subcarriers(&self) -> u32 {
        // a product that is a whole number but for its rounding is that number
        (self.bandwidth_hz * (self.symbol_s - self.prefix_s) * (1.0 + 1e-12)).floor() as u32
    }

    /// Sub-carriers M: those stated, or else those that fit.
    pub fn used_subcarriers(&self) -> u32 {
        match self.subcarriers {
            0 => self.most_subcarriers(),
            stated => stated,
        }
    }

    /// Spacing of the sub-carriers in Hz.
    pub fn spacing_hz(&self) -> f64 {
        self.bandwidth_hz / f64::from(self.used_subcarriers())
    }

    /// Where the users' bits are from, in a sentence that stands beside every throughput.
    pub fn channels(&self) -> &'static str {
        match (&self.slot_bit, self.people) {
            (Some(_), _) => "The bits of a slot are stated: no user's channel is simulated.",
            (None, false) => "The users' channels are empty of people.",
            (None, true) => "The people of the scenario are in the users' channels.",
        }
    }
}

impl Scenario {
    pub(super) fn check_communication(&self, c: &mut Rules) {
        let m = &self.communication;
        self.check_symbol(c);
        c.within("communication.power_w", m.power_w, 1e-9, 1e3);
        c.within("communication.noise_figure_db", m.noise_figure_db, 0.0, 40.0);
        c.count("communication.draws", m.draws, 1, 1_000_000);
        c.count("communication.cases (how many)", m.cases.len() as u32, 1, 16);
        for (case, users) in m.cases.iter().enumerate() {
            c.count(&format!("communication.cases[{case}] (users)"), users.len() as u32, 1, 8);
            for (k, position) in users.iter().enumerate() {
                let name = format!("communication.cases[{case}][{k}]");
                c.inside(&name, position, &self.room.size_m);
                let distance = position
                    .iter()
                    .zip(&self.radar.position_m)
                    .map(|(a, b)| (a - b) * (a - b))
                    .sum::<f64>()
                    .sqrt();
                c.legal(
                    &name,
                    format!("{position:?}"),
                    distance >= 0.1,
                    "at least 0.1 m from the base station",
                );
            }
        }
        if let Some(known) = &m.slot_bit {
            let (shape, cases): (Vec<usize>, Vec<usize>) =
                (known.iter().map(Vec::len).collect(), m.cases.iter().map(Vec::len).collect());
            let legal = format!("{cases:?}, one number for each user of communication.cases");
            c.legal("communication.slot_bit (users)", format!("{shape:?}"), shape == cases, &legal);
            for (case, bits) in known.iter().enumerate() {
                for (k, &bit) in bits.iter().enumerate() {
                    c.within(&format!("communication.slot_bit[{case}][{k}]"), bit, 1.0, 1e9);
                }
            }
        }
    }

    /// The OFDM symbol and what a sub-carrier carries in it.
    fn check_symbol(&self, c: &mut Rules) {
        let m = &self.communication;
        c.within("communication.bandwidth_hz", m.bandwidth_hz, 1e4, 10e9);
        c.beside("communication.symbol_s", m.symbol_s, [1e-7, self.frame.slot_s], "at most a slot");
        let shorter = (0.0..m.symbol_s).contains(&m.prefix_s);
        c.legal("communication.prefix_s", m.prefix_s, shorter, "at least 0, below communication.symbol_s");
        c.count("communication.subcarriers", m.subcarriers, 0, SUBCARRIERS);
        if shorter {
            let most = m.most_subcarriers();
            let fits = match m.subcarriers {
                0 => (1..=SUBCARRIERS).contains(&most),
                stated => stated <= most,
            };
            let legal = format!(
                "at most the {most} that fit bandwidth_hz x (symbol_s - prefix_s), or 0 where 1 to {SUBCARRIERS} fit"
            );
            c.legal("communication.subcarriers", m.subcarriers, fits, &legal);
        }
        c.within("communication.modulation_bit", m.modulation_bit, 0.0, 12.0);
        let whole_bit = m.modulation_bit == 0.0 || m.modulation_bit >= 1.0;
        c.legal("communication.modulation_bit", m.modulation_bit, whole_bit, "0 (no limit) or at least 1");
        c.within("communication.evm_percent", m.evm_percent, 0.0, 50.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Override;

    fn set(set: &[&str]) -> Result<Scenario, String> {
        let set: Vec<Override> = set.iter().map(|one| one.parse().unwrap()).collect();
        Scenario::default().with(&set, "built in").map_err(|error| error.to_string())
    }

    #[test]
    fn sub_carriers_follow_from_bandwidth_symbol_and_prefix() {
        let found = |fields: &[&str]| set(fields).unwrap().communication.used_subcarriers();
        assert_eq!(found(&["communication.subcarriers=64"]), 64);
        assert_eq!(found(&["communication.subcarriers=0"]), 467);
        assert_eq!(found(&["communication.subcarriers=0", "communication.prefix_s=0"]), 500);
        // the 64 sub-carriers of a 20 MHz IEEE 802.11a symbol: 4 us with a prefix of 0.8 us
        let wifi = ["subcarriers=0", "bandwidth_hz=20e6", "symbol_s=4e-6", "prefix_s=0.8e-6"];
        let wifi = wifi.map(|one| format!("communication.{one}"));
        let scenario = set(&wifi.each_ref().map(String::as_str)).unwrap();
        assert_eq!(scenario.communication.used_subcarriers(), 64);
        assert_eq!(scenario.communication.spacing_hz(), 312_500.0);
    }

    #[test]
    fn a_symbol_that_cannot_be_is_refused() {
        let refused = |fields: &[&str], words: &[&str]| {
            let error = set(fields).unwrap_err();
            words.iter().for_each(|word| assert!(error.contains(word), "{word} is not in: {error}"));
        };
        refused(&["communication.prefix_s=50e-6"], &["communication.prefix_s is 0.00005", "below"]);
        refused(&["communication.prefix_s=-1e-6"], &["communication.prefix_s is -0.000001", "at least 0"]);
        refused(
            &["communication.subcarriers=468"],
            &["communication.subcarriers is 468", "at most the 467 that fit"],
        );
        refused(
            &["communication.subcarriers=0", "communication.bandwidth_hz=1e4"],
            &["communication.subcarriers is 0", "0 where 1 to 65536 fit"],
        );
        refused(
            &["communication.subcarriers=0", "communication.bandwidth_hz=10e9"],
            &["communication.subcarriers is 0", "0 where 1 to 65536 fit"],
        );
        refused(&["communication.modulation_bit=13"], &["communication.modulation_bit is 13", "0 to 12"]);
        refused(
            &["communication.modulation_bit=0.5"],
            &["communication.modulation_bit is 0.5", "at least 1"],
        );
        refused(&["communication.evm_percent=51"], &["communication.evm_percent is 51", "0 to 50"]);
        refused(&["communication.evm_percent=-1"], &["communication.evm_percent is -1", "0 to 50"]);
        set(&["communication.modulation_bit=8", "communication.evm_percent=3.5"]).unwrap();
        set(&["communication.modulation_bit=7.4063", "communication.people=true"]).unwrap();
    }

    #[test]
    fn a_sentence_says_whether_people_are_in_the_channels() {
        let channels = |fields: &[&str]| set(fields).unwrap().communication.channels();
        assert!(channels(&["communication.people=false"]).contains("empty of people"));
        assert!(!channels(&[]).contains("empty"));
        assert!(channels(&["communication.slot_bit=[[1,2,3],[1,2,3]]"]).contains("stated"));
    }
}
