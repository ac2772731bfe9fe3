//! Kubernetes: an Indexed Job with a completion a shard, the plan in a ConfigMap, the results on a claim that many nodes write to.
//!
//! Kubernetes has no jobs that depend on others: the merge is a manifest of its own, to apply when the first is complete. A pod
//! that is killed is tried again three times; one that refuses its input (exit code 2) is not.

use super::plan::{PLAN, Sweep};
use super::shard::COMPLETIONS;
use crate::results::Submitted;
use crate::store::output::{Output, OutputError, to_json};
use crate::text::printable_json;
use serde_json::{Value, json};

/// Writes `sweep.yaml` and `merge.yaml`, and the resolved plan, for an image with the entry point sdp3 and the name of a claim. Every
/// document in them is JSON, which YAML contains: a name cannot become a field.
///
/// # Errors
///
/// A folder of another sweep, or one that cannot be written.
pub fn write(
    sweep: &Sweep,
    shards: u32,
    (image, claim): (&str, &str),
    output: &Output,
) -> Result<Submitted, OutputError> {
    sweep.open(output)?;
    let name = &sweep.plan.name;
    let manifests = [
        ("sweep.yaml", vec![plan(sweep), indexed(name, shards, image, claim)]),
        ("merge.yaml", vec![merge(name, image, claim)]),
    ];
    let mut files = Vec::new();
    for (file, documents) in manifests {
        let texts: Vec<String> =
            documents.iter().map(|one| printable_json(&to_json(one)).into_owned()).collect();
        let text = texts.join("\n---\n") + "\n";
        files.push(output.write(file, text.as_bytes())?.display().to_string());
    }
    Ok(Submitted { shards, files, array: None, merge: None })
}

fn plan(sweep: &Sweep) -> Value {
    let name = format!("{}-plan", sweep.plan.name);
    json!({
        "apiVersion": "v1",
        "kind": "ConfigMap",
        "metadata": {"name": name},
        "data": {PLAN: sweep.plan.to_toml()},
    })
}

fn indexed(name: &str, shards: u32, image: &str, claim: &str) -> Value {
    json!({
        "apiVersion": "batch/v1",
        "kind": "Job",
        "metadata": {"name": name},
        "spec": {
            "completionMode": "Indexed",
            "completions": shards,
            "parallelism": shards,
            "backoffLimitPerIndex": 3,
            "podFailurePolicy": {"rules": [{
                "action": "FailIndex",
                "onExitCodes": {"containerName": "sdp3", "operator": "In", "values": [2]},
            }]},
            "template": {"spec": {
                "restartPolicy": "Never",
                "containers": [{
                    "name": "sdp3",
                    "image": image,
                    "args": ["sweep", format!("/plan/{PLAN}"), "--out", format!("/results/{name}")],
                    "env": [{"name": COMPLETIONS, "value": shards.to_string()}],
                    "resources": {"requests": {"cpu": "1", "memory": "1Gi"}},
                    "volumeMounts": [
                        {"name": "plan", "mountPath": "/plan"},
                        {"name": "results", "mountPath": "/results"},
                    ],
                }],
                "volumes": [
                    {"name": "plan", "configMap": {"name": format!("{name}-plan")}},
                    {"name": "results", "persistentVolumeClaim": {"claimName": claim}},
                ],
            }},
        },
    })
}

/// To be applied when the job is complete.
fn merge(name: &str, image: &str, claim: &str) -> Value {
    json!({
        "apiVersion": "batch/v1",
        "kind": "Job",
        "metadata": {"name": format!("{name}-merge")},
        "spec": {
            "backoffLimit": 1,
            "template": {"spec": {
                "restartPolicy": "Never",
                "containers": [{
                    "name": "sdp3",
                    "image": image,
                    "args": ["merge", format!("/results/{name}")],
                    "volumeMounts": [{"name": "results", "mountPath": "/results"}],
                }],
                "volumes": [{"name": "results", "persistentVolumeClaim": {"claimName": claim}}],
            }},
        },
    })
}
