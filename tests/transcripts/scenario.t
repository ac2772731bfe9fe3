Scenarios: listed, shown, written, checked, set field by field.

  $ cat >bad.toml <<'END'
  > [radar]
  > carrier_hz = 1.0
  > colour = "red"
  > power_w = "much"
  > [channel]
  > rho = 1.5
  > [frame]
  > sensing_slots = [400, 300, 5000]
  > END

  $ sdp3 scenario list

  $ sdp3 scenario show small-radar

  $ sdp3 scenario new room.toml --set radar.carrier_hz=5.8e9

  $ sdp3 scenario new room.toml

  $ sdp3 scenario check room.toml

  $ sdp3 scenario check room.toml --json

  $ sdp3 scenario check bad.toml

  $ sdp3 scenario check bad.toml --json

  $ sdp3 scenario check missing.toml

  $ sdp3 scenario show nowhere

  $ sdp3 scenario show --set radar.carrier_hz=fast

  $ sdp3 scenario show --set radar.carier_hz=1e9

  $ sdp3 scenario show --set channel.rho

  $ sdp3 scenario show --set channel.rho=1.5
