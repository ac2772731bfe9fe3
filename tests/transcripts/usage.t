What no command understands.

  $ sdp3 nonsense
  error: unrecognized subcommand 'nonsense'
  
  Usage: sdp3 [OPTIONS] [COMMAND]
  
  For more information, try '--help'.
  [2]

  $ sdp3 run --sed 1
  error: unexpected argument '--sed' found
  
    tip: a similar argument exists: '--seed'
  
  Usage: sdp3 run --seed <SEED>
  
  For more information, try '--help'.
  [2]

  $ sdp3 --scenario nowhere.toml channels
  sdp3: nowhere.toml: No such file or directory (os error 2)
  [2]

  $ sdp3 --seed -1
  error: unexpected argument '-1' found
  
  Usage: sdp3 [OPTIONS] [COMMAND]
  
  For more information, try '--help'.
  [2]
