//! What a scenario says where its file says nothing: the paper's section VI where it gives a value.

use super::{
    Advance, ArMode, Channel, Clusters, Communication, Doppler, Environment, Frame, Furniture, Interior,
    Learning, Material, Model, OperatingRule, Optimizer, Polarisation, Radar, Room, Scenario, Schedule,
    SpectrogramSettings, Surface, Target, Tgn,
};

impl Default for Scenario {
    fn default() -> Self {
        Scenario {
            name: "conference-room".into(),
            room: Room::default(),
            radar: Radar::default(),
            frame: Frame::default(),
            channel: Channel::default(),
            target: Target::default(),
            spectrogram: SpectrogramSettings::default(),
            learning: Learning::default(),
            communication: Communication::default(),
            optimizer: OperatingRule::default(),
        }
    }
}

impl Default for Room {
    fn default() -> Self {
        let surface = |material, thickness_m| Surface { material, thickness_m };
        Room {
            size_m: [3.0, 4.5, 3.0],
            walls: surface(Material::Concrete, 0.2),
            floor: surface(Material::Concrete, 0.2),
            ceiling: surface(Material::Plasterboard, 0.0125),
            furniture: vec![
                Furniture { centre_m: [0.6, 3.2, 0.7], cross_section_dbsm: -5.0, size_m: None },
                Furniture { centre_m: [0.5, 1.8, 0.5], cross_section_dbsm: -10.0, size_m: None },
                Furniture { centre_m: [2.6, 2.2, 0.5], cross_section_dbsm: -10.0, size_m: None },
            ],
        }
    }
}

impl Default for Frame {
    fn default() -> Self {
        Frame {
            slot_s: 250e-6,
            period_slots: 4000,
            spacing_slots: 3,
            sensing_slots: vec![200, 300, 400, 500, 600, 1000],
        }
    }
}

impl Default for Channel {
    fn default() -> Self {
        Channel {
            model: Model::Dahc,
            rho: None,
            mode: ArMode::Rician,
            k_factor_db: 15.0,
            clutter_gain_db: 0.0,
            clusters: Clusters::ByCarrier,
            advance: Advance::SensingSlot,
            stationary_start: false,
            tgn: Tgn::B,
            blockage: false,
            shadowing: true,
            occlusion: true,
            environment: Environment::ConferenceRoom,
            polarisation: Polarisation::Vertical,
            doppler: Doppler::Bell,
            interior: Interior::Furnished,
            scattering: 0.2,
            diffraction: true,
            double_bounce: false,
            line_of_sight: true,
            interferer: false,
        }
    }
}

impl Default for Target {
    fn default() -> Self {
        Target {
            start_m: [2.7, 4.2],
            waypoints_m: Vec::new(),
            turns: true,
            heading_spread_deg: 15.0,
            speed_jitter: 0.05,
            adult_height_m: [1.6, 1.9],
            child_height_m: [0.9, 1.2],
            capture: None,
            others: Vec::new(),
        }
    }
}

impl Default for SpectrogramSettings {
    fn default() -> Self {
        SpectrogramSettings {
            first_kept: 0,
            last_kept: 8,
            window: 128,
            beta: 4.0,
            hop: 8,
            bins_per_row: 1,
            range_db: 40.0,
        }
    }
}

impl Default for Learning {
    fn default() -> Self {
        Learning {
            train_per_class: 200,
            recording_slots: 1000,
            windows: 8,
            test_per_class: 500,
            epochs: 20,
            batch: 50,
            optimizer: Optimizer::Adamw,
            schedule: Schedule::OneCycle,
            learning_rate: 5e-3,
            weight_decay: 1e-2,
            mixup: 0.0,
            mask_rows: 0,
            validation: 0.0,
            patience: 0,
            qat_above: 0.01,
            qat_images: 2000,
            channels: 16,
            blocks: 5,
            stem_stride: 2,
        }
    }
}

impl Default for Communication {
    fn default() -> Self {
        Communication {
            subcarriers: 0,
            bandwidth_hz: 10e6,
            symbol_s: 50e-6,
            prefix_s: 3.3e-6,
            modulation_bit: 8.0,
            evm_percent: 3.5,
            power_w: 1.0,
            noise_figure_db: 10.0,
            cases: vec![
                vec![[1.5, 3.0, 1.0], [2.5, 1.0, 1.0], [0.5, 1.0, 1.0]],
                vec![[1.5, 2.8, 1.0], [2.3, 1.0, 1.0], [0.7, 1.0, 1.0]],
            ],
            draws: 200,
            people: true,
            slot_bit: None,
        }
    }
}

impl Default for OperatingRule {
    fn default() -> Self {
        OperatingRule { accuracy_weight: 0.5, case: 1, zone_ratio: 0.2 }
    }
}
