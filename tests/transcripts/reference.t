Schemas, completions and man pages.

  $ sdp3 schema

  $ sdp3 schema scenario-check

  $ sdp3 schema nothing

  $ sdp3 completions tcsh

  $ sdp3 man pages

  $ sdp3 man /proc/sdp3
