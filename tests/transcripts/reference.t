Schemas, completions and man pages.

  $ sdp3 schema
  calibrate
  channels
  classify
  early-exits
  export
  gallery
  import
  infer
  inspect
  man
  merge
  model-keygen
  model-show
  model-sign
  model-verify
  optimize
  predict
  quantize
  report
  reproduce
  run
  scenario
  scenario-check
  scenario-list
  scenario-new
  scenario-show
  schedule
  schema
  simulate
  study
  sweep
  targets
  train
  verify

  $ sdp3 schema scenario-check
  {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "description": "A scenario file that was checked.",
    "properties": {
      "errors": {
        "description": "Everything that is wrong with it; nothing if it may be used.",
        "items": {
          "type": "string"
        },
        "type": "array"
      },
      "file": {
        "description": "The file.",
        "type": "string"
      }
    },
    "required": [
      "file",
      "errors"
    ],
    "title": "Checked",
    "type": "object"
  }

  $ sdp3 schema nothing
  error: invalid value 'nothing' for '[COMMAND]'
    [possible values: calibrate, channels, classify, early-exits, export, gallery, import, infer, inspect, man, merge, model-keygen, model-show, model-sign, model-verify, optimize, predict, quantize, report, reproduce, run, scenario, scenario-check, scenario-list, scenario-new, scenario-show, schedule, schema, simulate, study, sweep, targets, train, verify]
  
  For more information, try '--help'.
  [2]

  $ sdp3 completions tcsh
  error: invalid value 'tcsh' for '<SHELL>'
    [possible values: bash, elvish, fish, powershell, zsh]
  
    tip: a similar value exists: 'zsh'
  
  For more information, try '--help'.
  [2]

  $ sdp3 man pages
  pages/sdp3.1
  pages/sdp3-run.1
  pages/sdp3-simulate.1
  pages/sdp3-targets.1
  pages/sdp3-calibrate.1
  pages/sdp3-inspect.1
  pages/sdp3-classify.1
  pages/sdp3-channels.1
  pages/sdp3-gallery.1
  pages/sdp3-train.1
  pages/sdp3-study.1
  pages/sdp3-reproduce.1
  pages/sdp3-sweep.1
  pages/sdp3-merge.1
  pages/sdp3-quantize.1
  pages/sdp3-export.1
  pages/sdp3-import.1
  pages/sdp3-infer.1
  pages/sdp3-model.1
  pages/sdp3-model-show.1
  pages/sdp3-model-keygen.1
  pages/sdp3-model-sign.1
  pages/sdp3-model-verify.1
  pages/sdp3-verify.1
  pages/sdp3-predict.1
  pages/sdp3-optimize.1
  pages/sdp3-early-exits.1
  pages/sdp3-schedule.1
  pages/sdp3-report.1
  pages/sdp3-scenario.1
  pages/sdp3-scenario-list.1
  pages/sdp3-scenario-show.1
  pages/sdp3-scenario-new.1
  pages/sdp3-scenario-check.1
  pages/sdp3-schema.1
  pages/sdp3-completions.1
  pages/sdp3-man.1

  $ sdp3 man /proc/sdp3
  sdp3: /proc/sdp3: cannot be written: No such file or directory (os error 2)
  [2]

  $ sdp3 completions bash | grep -c 'compgen -W "dahc primitive ray-tracing statistical 80211ay 80211ax 38901 quadriga metis"'
  1

  $ sdp3 completions bash | grep -c 'compgen -W "host-reference cortex-m3 cortex-m4f '
  2

  $ sdp3 completions bash | grep -c 'compgen -W "standing child-walking child-pacing adult-walking '
  4

  $ sdp3 completions bash | grep -c 'compgen -W "vapor_pressure pow3 log_power '
  1
