//! The room: its size, what its surfaces are made of and what stands in it.

use super::Scenario;
use super::rules::Rules;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Building materials of Recommendation ITU-R P.2040-3.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Material {
    /// Concrete.
    Concrete,
    /// Brick.
    Brick,
    /// Plasterboard.
    Plasterboard,
    /// Wood.
    Wood,
    /// Glass.
    Glass,
    /// Ceiling board.
    CeilingBoard,
    /// Chipboard.
    Chipboard,
    /// Plywood.
    Plywood,
    /// Marble.
    Marble,
    /// Metal.
    Metal,
}

/// A surface of the room: a slab in air.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Surface {
    /// Its material.
    pub material: Material,
    /// Its thickness in m.
    pub thickness_m: f64,
}

/// A piece of furniture: a scatterer that does not move.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Furniture {
    /// Where it scatters in m.
    pub centre_m: [f64; 3],
    /// Its radar cross section in dBsm.
    pub cross_section_dbsm: f64,
    /// Width and height in m of what stands in the way of waves (`ray-tracing`, `metis`); absent: nothing does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size_m: Option<[f64; 2]>,
}

/// Room: a box with one corner at the origin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Room {
    /// Length (x), width (y), height (z) in m. Positions and walks stay inside. Links, and with them the throughput, depend on it
    /// only where the channel model reflects at walls.
    pub size_m: [f64; 3],
    /// What the four walls are made of (the hybrid channel with `mode = "rician"`, `ray-tracing`, `metis`).
    pub walls: Surface,
    /// What the floor is made of.
    pub floor: Surface,
    /// What the ceiling is made of.
    pub ceiling: Surface,
    /// What stands in the room.
    pub furniture: Vec<Furniture>,
}

impl Scenario {
    pub(super) fn check_room(&self, c: &mut Rules) {
        let room = &self.room;
        for (axis, &size) in ["x", "y", "z"].iter().zip(&room.size_m) {
            c.within(&format!("room.size_m ({axis})"), size, 1.0, 100.0);
        }
        for (name, surface) in [("walls", &room.walls), ("floor", &room.floor), ("ceiling", &room.ceiling)] {
            c.within(&format!("room.{name}.thickness_m"), surface.thickness_m, 1e-3, 10.0);
        }
        c.count("room.furniture (how many)", room.furniture.len() as u32, 0, 100);
        for (k, piece) in room.furniture.iter().enumerate() {
            c.inside(&format!("room.furniture[{k}].centre_m"), &piece.centre_m, &room.size_m);
            c.within(
                &format!("room.furniture[{k}].cross_section_dbsm"),
                piece.cross_section_dbsm,
                -60.0,
                30.0,
            );
            for (side, size) in ["width", "height"].iter().zip(piece.size_m.into_iter().flatten()) {
                c.within(&format!("room.furniture[{k}].size_m ({side})"), size, 0.01, 10.0);
            }
        }
    }
}
