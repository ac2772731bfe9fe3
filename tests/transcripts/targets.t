Point targets: written, described, refused.

  $ sdp3 targets --classes standing --every-s 0.5 --duration-s 1
     targets  point targets
     targets  1 files of 2 instants in out
  out/targets-standing.csv

  $ cut -d, -f 1-4 out/targets-standing.csv
  time_s,part,x_m,y_m
  0,head,2.700618359166843,4.198896406464681
  0,torso,2.700316021172202,4.198298454039223
  0,left_shoulder,2.823703217351786,4.1351318879868115
  0,right_shoulder,2.576300932862731,4.260223198972216
  0,left_upper_arm,2.8216436312979054,4.1310584895343325
  0,right_upper_arm,2.5742413468088503,4.256149800519738
  0,left_lower_arm,2.811895801348621,4.111779485764839
  0,right_lower_arm,2.5644960166935613,4.2368757408557665
  0,left_hip,2.7918534785351734,4.152794743053697
  0,right_hip,2.609406455939118,4.24504398614417
  0,left_thigh,2.791822481640642,4.152747107002345
  0,right_thigh,2.6094008563750917,4.245046579962402
  0,left_shank,2.791905518923083,4.1529387275654575
  0,right_shank,2.6124987423043136,4.25120083402221
  0,left_foot,2.7230573183511813,4.016787992062927
  0,right_foot,2.546915137794019,4.121507467265851
  0.5,head,2.7011393553265775,4.20029062757714
  0.5,torso,2.70058376902184,4.1991918103358135
  0.5,left_shoulder,2.823717716891327,4.1355243794675305
  0.5,right_shoulder,2.5763154324022715,4.260615690452935
  0.5,left_upper_arm,2.821911379147543,4.131951845830922
  0.5,right_upper_arm,2.574509094658488,4.2570431568163265
  0.5,left_lower_arm,2.812416797508355,4.113173706877299
  0.5,right_lower_arm,2.565017012853296,4.238269961968225
  0.5,left_hip,2.792374474694908,4.154188964166156
  0.5,right_hip,2.6099274520988525,4.246438207256629
  0.5,left_thigh,2.792343477800377,4.154141328114805
  0.5,right_thigh,2.6099218525348262,4.246440801074861
  0.5,left_shank,2.7924265150828176,4.154332948677917
  0.5,right_shank,2.613019738464048,4.25259505513467
  0.5,left_foot,2.723578314510916,4.018182213175386
  0.5,right_foot,2.5474361339537537,4.1229016883783105

  $ ls out
  targets-scenario.toml
  targets-standing.csv
  targets.json

  $ sdp3 targets --classes adult-walking --every-s 0.25 --duration-s 0.5 --index 3 --seed 7 --json -q
  {
    "radar_m": [
      1.5,
      1.0,
      1.0
    ],
    "carrier_hz": 3500000000.0,
    "centre_hz": 3505000000.0,
    "index": 3,
    "every_s": 0.25,
    "instants": 2,
    "parts": [
      "head",
      "torso",
      "left_shoulder",
      "right_shoulder",
      "left_upper_arm",
      "right_upper_arm",
      "left_lower_arm",
      "right_lower_arm",
      "left_hip",
      "right_hip",
      "left_thigh",
      "right_thigh",
      "left_shank",
      "right_shank",
      "left_foot",
      "right_foot"
    ],
    "files": [
      {
        "file": "targets-adult-walking.csv",
        "person": {
          "class": "adult-walking",
          "child": false,
          "height_m": 1.7197743053108476,
          "speed_m_s": 0.9199432214417438,
          "heading_deg": -106.62699516515333,
          "phase": 0.22463724424950005,
          "start_m": [
            2.7,
            4.2
          ]
        }
      }
    ]
  }

  $ sdp3 targets --every-s 0
  sdp3: command line: --every-s is 0, must be 0.00001 to 100 s
  [2]

  $ sdp3 targets --duration-s 1000
  sdp3: command line: --duration-s is 1000, must be 0.00001 to 120 s
  [2]

  $ sdp3 targets --classes flying
  error: invalid value 'flying' for '--classes <NAMES>'
    [possible values: standing, child-walking, child-pacing, adult-walking, adult-pacing, child-stepping, adult-stepping, child-running, adult-running, sitting-down, standing-up, falling, bending, waving, jumping]
  
    tip: a similar value exists: 'falling'
  
  For more information, try '--help'.
  [2]

  $ sdp3 targets --every-s 0.00001 --duration-s 120 --max-time 1m
  sdp3: --duration-s / --every-s is 120 / 0.00001, 60000000 instants of all classes, about 1 h in all, must be at most 1 min (--max-time)
  [2]
