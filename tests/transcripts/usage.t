What no command understands.

  $ sdp3 nonsense

  $ sdp3 run --sed 1

  $ sdp3 --scenario nowhere.toml channels

  $ sdp3 --seed -1
