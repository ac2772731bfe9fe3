//! Which bone of a named skeleton is which joint.
//!
//! Names as CMU, ACCAD, Mixamo, Bandai-Namco and Poser write them; case, `_`, `-`, `.`, spaces and what stands before a
//! colon do not matter, nor does whether the side comes first (`LeftArm`, `lShldr`, `L_Arm`) or last (`Arm_L`).

use super::super::gait::{JOINTS, joint};
use super::{CaptureError, JOINT_NAMES, refuse};

/// A joint of a skeleton; the parent stands before it.
#[derive(Debug, Clone)]
pub(super) struct Bone {
    /// Name, empty for an end site.
    pub(super) name: String,
    /// Index of the parent.
    pub(super) parent: Option<usize>,
    /// Whether it is an end site.
    pub(super) end: bool,
}

/// Of the joints without a side, the names from the most to the least wanted.
const MIDDLE: [(usize, &[&str]); 3] = [
    (joint::BASE, &["hips", "pelvis", "hip"]),
    (joint::NECK, &["neck", "neck1"]),
    (joint::HEAD, &["headtopend", "headend", "head"]),
];
/// Of the left joints, the same without the side. `LeftShoulder` is a collar bone wherever there is a `LeftArm`.
const SIDED: [(usize, &[&str]); 7] = [
    (joint::SHOULDER, &["arm", "uparm", "upperarm", "shldr", "shoulder"]),
    (joint::ELBOW, &["forearm", "lowarm", "lowerarm", "elbow"]),
    (joint::HAND, &["hand", "wrist"]),
    (joint::HIP, &["upleg", "upperleg", "thigh", "hip"]),
    (joint::KNEE, &["leg", "lowleg", "lowerleg", "shin", "calf", "knee"]),
    (joint::ANKLE, &["foot", "ankle"]),
    (joint::TOE, &["toebase", "toe", "toes"]),
];

/// Index of the bone of each joint. The top of the head is the end site of the head where there is one; the toe of a
/// foot without toes is the end site of the foot.
///
/// # Errors
///
/// The joint that no bone is.
pub(super) fn find(bones: &[Bone]) -> Result<[usize; JOINTS], CaptureError> {
    let names: Vec<String> = bones.iter().map(|bone| plain(&bone.name)).collect();
    let named = |wanted: &[String]| wanted.iter().find_map(|w| names.iter().position(|name| name == w));
    let end_of = |of: usize| bones.iter().position(|bone| bone.end && bone.parent == Some(of));
    let missing = |j: usize, wanted: &[String]| {
        refuse(
            "hierarchy",
            format!("joint {}", JOINT_NAMES[j]),
            "missing",
            format!("one of {}", wanted.join(", ")),
        )
    };
    let mut found = [0; JOINTS];
    for (j, parts) in MIDDLE {
        let wanted: Vec<String> = parts.iter().map(|&part| part.to_owned()).collect();
        found[j] = named(&wanted).ok_or_else(|| missing(j, &wanted))?;
    }
    if names[found[joint::HEAD]] == "head" {
        found[joint::HEAD] = end_of(found[joint::HEAD]).unwrap_or(found[joint::HEAD]);
    }
    for (left, parts) in SIDED {
        for (side, [word, letter]) in [["left", "l"], ["right", "r"]].into_iter().enumerate() {
            let j = left + side;
            let spell = |part: &&str| {
                [
                    format!("{word}{part}"),
                    format!("{letter}{part}"),
                    format!("{part}{word}"),
                    format!("{part}{letter}"),
                ]
            };
            let wanted: Vec<String> = parts.iter().flat_map(spell).collect();
            let toe = if left == joint::TOE { end_of(found[joint::ANKLE + side]) } else { None };
            found[j] = named(&wanted).or(toe).ok_or_else(|| missing(j, &wanted))?;
        }
    }
    Ok(found)
}

/// A name without its prefix, case and separators.
fn plain(name: &str) -> String {
    let last = name.rsplit(':').next().unwrap_or(name);
    let plain: String = last.chars().filter(|c| c.is_alphanumeric()).collect::<String>().to_lowercase();
    match plain.strip_prefix("mixamorig") {
        Some(rest) => rest.trim_start_matches(|c: char| c.is_ascii_digit()).to_owned(),
        None => plain,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bones from a list of `name` and `>` for the end site of the bone before.
    fn bones(list: &str) -> Vec<Bone> {
        let mut bones: Vec<Bone> = Vec::new();
        for word in list.split_whitespace() {
            let parent = bones.len().checked_sub(1);
            let (name, end) = if word == ">" { ("", true) } else { (word, false) };
            bones.push(Bone { name: name.to_owned(), parent, end });
        }
        bones
    }

    fn names(list: &str) -> Vec<String> {
        let bones = bones(list);
        let name = |i: usize| match bones[i].end {
            true => format!("{}>", bones[i - 1].name),
            false => bones[i].name.clone(),
        };
        find(&bones).unwrap().map(name).to_vec()
    }

    #[test]
    fn common_skeletons_are_known() {
        let cmu = names(
            "Hips LHipJoint LeftUpLeg LeftLeg LeftFoot LeftToeBase > RHipJoint RightUpLeg RightLeg RightFoot \
             RightToeBase > LowerBack Spine Spine1 Neck Neck1 Head > LeftShoulder LeftArm LeftForeArm LeftHand \
             LeftFingerBase > LThumb > RightShoulder RightArm RightForeArm RightHand RightFingerBase > RThumb >",
        );
        assert_eq!(cmu[..5], ["Hips", "Neck", "Head>", "LeftArm", "RightArm"]);
        assert_eq!(
            cmu[9..],
            [
                "LeftUpLeg",
                "RightUpLeg",
                "LeftLeg",
                "RightLeg",
                "LeftFoot",
                "RightFoot",
                "LeftToeBase",
                "RightToeBase"
            ]
        );
        let biovision = names(
            "Hips LeftHip LeftKnee LeftAnkle > RightHip RightKnee RightAnkle > Chest LeftCollar LeftUpArm LeftLowArm \
             LeftHand > RightCollar RightUpArm RightLowArm RightHand > Neck Head >",
        );
        assert_eq!(biovision[13..], ["LeftAnkle", "RightAnkle", "LeftAnkle>", "RightAnkle>"]);
        assert_eq!(biovision[3..7], ["LeftUpArm", "RightUpArm", "LeftLowArm", "RightLowArm"]);
        let mixamo = names(
            "mixamorig:Hips mixamorig:Neck mixamorig1:Head mixamorig:HeadTop_End > mixamorig_LeftArm x:LeftForeArm \
             LeftHand LeftUpLeg LeftLeg LeftFoot LeftToeBase RightArm RightForeArm RightHand RightUpLeg RightLeg \
             RightFoot RightToeBase",
        );
        assert_eq!(
            mixamo[..4],
            ["mixamorig:Hips", "mixamorig:Neck", "mixamorig:HeadTop_End", "mixamorig_LeftArm"]
        );
        let last = names(
            "Pelvis Neck Head Shoulder_L UpperArm_L LowerArm_L Hand_L UpperLeg_L LowerLeg_L Foot_L Toes_L Shoulder_R \
             UpperArm_R LowerArm_R Hand_R UpperLeg_R LowerLeg_R Foot_R Toes_R",
        );
        assert_eq!(last[2..5], ["Head", "UpperArm_L", "UpperArm_R"]);
    }

    #[test]
    fn a_missing_joint_is_named() {
        let why = find(&bones("Hips Neck Head > LeftArm RightArm LeftForeArm")).unwrap_err().to_string();
        assert!(why.contains("joint right_elbow is missing") && why.contains("rightforearm"), "{why}");
        assert!(find(&[]).unwrap_err().to_string().contains("joint base"));
    }
}
