Help: the tool and every command, with examples.

  $ sdp3 --help

  $ sdp3 run --help

  $ sdp3 simulate --help

  $ sdp3 calibrate --help

  $ sdp3 channels --help

  $ sdp3 gallery --help

  $ sdp3 train --help

  $ sdp3 study --help

  $ sdp3 quantize --help

  $ sdp3 export --help

  $ sdp3 import --help

  $ sdp3 model --help

  $ sdp3 sign --help

  $ sdp3 key --help

  $ sdp3 verify --help

  $ sdp3 predict --help

  $ sdp3 optimize --help

  $ sdp3 anytime --help

  $ sdp3 schedule --help

  $ sdp3 report --help

  $ sdp3 scenario --help

  $ sdp3 schema --help

  $ sdp3 completions --help

  $ sdp3 man --help

  $ sdp3 scenario list --help

  $ sdp3 scenario show --help

  $ sdp3 scenario new --help

  $ sdp3 scenario check --help
