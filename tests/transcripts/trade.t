Learning curves, regions and schedules from a table of accuracies.

  $ cat >points.csv <<'END'
  > sensing_slots,accuracy,tested
  > 200,0.7885,500
  > 300,0.9016,500
  > 400,0.9142,500
  > 500,0.9309,500
  > 1000,0.9554,500
  > END

  $ sdp3 predict --points points.csv

  $ sdp3 predict --points nothing.csv

  $ sdp3 predict

  $ sdp3 optimize -q --points points.csv --accuracy 0.9

  $ sdp3 optimize -q --points points.csv --set communication.power_w=0.1 --sweep receivers=1,2

  $ sdp3 optimize --points points.csv --accuracy 1.5

  $ sdp3 optimize --points points.csv --curve spline

  $ sdp3 optimize -q --points points.csv --accuracy 0.99

  $ sdp3 schedule -q --periods 5 --sensing-slots 300

  $ sdp3 schedule -q --periods 5 --sensing-slots 5000

  $ sdp3 schedule

  $ sdp3 anytime
