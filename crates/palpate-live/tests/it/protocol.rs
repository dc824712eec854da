//! What page and server tell each other, as docs/reference/live-protocol.md has it.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use crate::common::{Client, DEVICE, FORCE, Play, Received, Samples, Stage, scene, sent};
use palpate_record::recording::{Entry, Recording};
use palpate_scene::method::MethodName;
use serde_json::{Value, json};

#[test]
fn client_receives_hello_state_and_status() {
    let stage = Stage::new(Play::default());
    let mut client = stage.client();
    let Received::Text(hello) = client.next() else {
        panic!("samples came first")
    };
    assert_eq!(hello["type"], "hello");
    assert_eq!(hello["protocol"], 1);
    assert_eq!(hello["title"], "A light block on the device, 100 Hz");
    let columns = hello["columns"].as_array().unwrap();
    assert_eq!(columns.len(), sent().count());
    for (messages, column) in columns.iter().zip(sent()) {
        assert_eq!(messages["name"], column.name);
    }
    let force = json!({"name": "force_on_device_n", "unit": "N"});
    let flags = json!({"name": "flags", "unit": ""});
    assert!(columns.contains(&force) && columns.contains(&flags));
    assert_eq!(hello["methods"].as_array().unwrap().len(), 14);
    assert_eq!(hello["methods"][12]["name"], "hfcr");
    assert_eq!(hello["methods"][12]["damping"], true);
    // It is read alone.
    let title = hello["methods"][12]["title"].as_str().unwrap();
    assert!(title.contains("energy-consistent force"), "{title}");
    assert_eq!(hello["limits"]["period_s"], json!([0.000_25, 0.05]));
    assert_eq!(
        hello["device"],
        json!({"name": "pointer", "axes": 1, "pointer": true, "largest_force_n": null, "lanes": 2})
    );
    assert_eq!(hello["side"], 1);
    let Received::Text(state) = client.next() else {
        panic!("samples came before the state")
    };
    assert_eq!(
        state,
        json!({
            "type": "state",
            "stiffness_n_per_m": 600.0,
            "mass_kg": 0.1,
            "virtual_force_n": -0.981,
            "period_s": 0.001,
            "model_device_mass_kg": 0.25,
            "model_delay_s": 0.0,
            "model_lag_s": 0.0,
            "model_gain": 1.0,
            "lanes": [{"method": "coupled", "damping_n_s_per_m": null, "running": true, "safety_stop": null, "safety_stop_method": null}],
            "recording": null,
            "hand_m": 0.0,
        })
    );
    let status = client.text("status");
    assert_eq!(status["clients"], 1);
    assert_eq!(status["recording"], Value::Null);
    for key in ["lateness_s", "tick_s"] {
        let spread = &status["lanes"][0][key];
        assert!(spread["median"].as_f64() <= spread["p99"].as_f64());
        assert!(spread["p99"].as_f64() <= spread["longest"].as_f64());
    }
}

#[test]
fn at_a_kilohertz_every_tick_is_a_row() {
    let stage = Stage::new(Play::default());
    let mut client = stage.client();
    let mut last: Option<Samples> = None;
    let mut rows = 0;
    // The status tells when the newest tick was that it counts.
    let (mut counted_to, mut is_row) = (None, false);
    while rows < 1000 || !is_row {
        let frame = match client.next() {
            Received::Samples(frame) => frame,
            Received::Text(text) => {
                if text["type"] == "status" && last.is_some() {
                    counted_to = text["lanes"][0]["t_s"].as_f64();
                    assert!(counted_to > Some(0.0), "{text}");
                }
                continue;
            }
        };
        let times = last.iter().chain([&frame]).flat_map(|frame| &frame.times);
        is_row |= times
            .into_iter()
            .any(|time| counted_to.is_some_and(|to| (time - to).abs() < 1e-6));
        assert_eq!((frame.lane, frame.run), (0, 0));
        assert_eq!(frame.columns.len(), sent().count());
        assert_eq!(frame.times.len(), frame.columns[0].len());
        if let Some(last) = &last {
            assert_eq!(frame.number, last.number + 1);
            assert!(frame.times[0] > *last.times.last().unwrap());
        } else {
            assert_eq!(frame.number, 0, "numbers are this client's");
        }
        assert!(frame.times.windows(2).all(|pair| pair[0] < pair[1]));
        rows += frame.times.len();
        last = Some(frame);
    }
}

#[test]
fn settings_are_sent_to_all_clients_and_refusals_to_the_requester() {
    let stage = Stage::new(Play::default());
    let (mut one, mut other) = (stage.client(), stage.client());
    one.say(r#"{"type":"set","stiffness_n_per_m":250,"mass_kg":null}"#);
    for client in [&mut one, &mut other] {
        let state = client.until("state", |state| state["stiffness_n_per_m"] == 250.0);
        assert_eq!(state["mass_kg"], Value::Null);
    }
    let note = other.until("note", |note| note["kind"] == "parameters");
    assert!(
        note["text"].as_str().unwrap().contains("a wall of 250 N/m"),
        "{note}"
    );
    for (request, about, words) in [
        (
            r#"{"type":"set","stiffness_n_per_m":-1}"#,
            "set",
            "10 to 10000",
        ),
        (
            // The first is right: all of it is refused.
            r#"{"type":"set","stiffness_n_per_m":300,"mass_kg":1e9}"#,
            "set",
            "0.005 to 5",
        ),
        (
            r#"{"type":"set","lanes":[{"method":"basic","damping_n_s_per_m":1}]}"#,
            "set",
            "has no damping",
        ),
        (r#"{"type":"rearm","lane":1}"#, "rearm", "0 to 0"),
        (r#"{"type":"hand","position_m":7}"#, "hand", "-1 to 1"),
        (r#"{"type":"hand"}"#, "hand", "position_m"),
    ] {
        one.say(request);
        let refused = one.text("refused");
        assert_eq!(refused["about"], about, "{request}");
        let text = refused["text"].as_str().unwrap();
        assert!(text.contains(words), "{request}: {text}");
    }
    let late = stage.client().text("state");
    assert_eq!(late["stiffness_n_per_m"], 250.0);
    one.say(r#"{"type":"set","stiffness_n_per_m":260}"#);
    let mut refusals = 0;
    loop {
        if let Received::Text(text) = other.next() {
            refusals += u32::from(text["type"] == "refused");
            if text["stiffness_n_per_m"] == 260.0 {
                break;
            }
        }
    }
    assert_eq!(refusals, 0, "of somebody else's requests");
}

#[test]
fn hand_follows_client_target_and_is_released_on_disconnect() {
    let stage = Stage::new(Play::default());
    let mut client = stage.client();
    client.say(r#"{"type":"hand","position_m":-0.04}"#);
    client.frame(|frame| (frame.column(DEVICE).last().unwrap() + 0.04).abs() < 0.005);
    client.until("state", |state| state["hand_m"] == -0.04);
    client.say(r#"{"type":"hand","position_m":null}"#);
    client.until("state", |state| state["hand_m"].is_null());
    assert_eq!(stage.hand.target(), None);
    client.say(r#"{"type":"hand","position_m":0.01}"#);
    let mut other = stage.client();
    other.until("state", |state| state["hand_m"] == 0.01);
    drop(client);
    other.until("state", |state| state["hand_m"].is_null());
    other.is_well();
}

#[test]
fn a_device_with_a_hand_of_its_own_is_not_led_and_has_one_lane() {
    let stage = Stage::new(Play {
        is_led: false,
        most_lanes: 1,
        ..Play::default()
    });
    let mut client = stage.client();
    let hello = client.text("hello");
    assert_eq!(hello["device"]["pointer"], false);
    assert_eq!(hello["device"]["lanes"], 1);
    client.say(r#"{"type":"hand","position_m":0}"#);
    let refused = client.text("refused");
    assert!(refused["text"].as_str().unwrap().contains("`pointer`"));
    client.say(r#"{"type":"set","lanes":[{"method":"basic"},{"method":"coupled"}]}"#);
    let refused = client.text("refused");
    let text = refused["text"].as_str().unwrap();
    assert!(text.contains("in one loop only"), "{text}");
    // It was opened for this rate.
    assert_eq!(hello["limits"]["period_s"], json!([0.001, 0.001]));
    client.say(r#"{"type":"set","period_s":0.002}"#);
    client.text("refused");
    client.is_well();
}

/// Another rate and another number of lanes are other loops: time begins again, and the devices are
/// where they were.
#[test]
fn another_rate_and_another_lane_begin_anew_where_the_device_is() {
    let stage = Stage::new(Play::default());
    let mut client = stage.client();
    client.say(r#"{"type":"hand","position_m":-0.05}"#);
    client.frame(|frame| (frame.column(DEVICE).last().unwrap() + 0.05).abs() < 0.005);
    client.say(r#"{"type":"set","period_s":0.00025}"#);
    let state = client.until("state", |state| state["period_s"] == 0.000_25);
    assert_eq!(state["lanes"][0]["running"], true);
    let frame = client.frame(|frame| frame.run == 1);
    assert!(frame.times[0] < 0.1, "{}", frame.times[0]);
    assert!((frame.column(DEVICE)[0] + 0.05).abs() < 0.01);
    client.say(
        r#"{"type":"set","lanes":[{"method":"basic"},{"method":"hfcr","damping_n_s_per_m":0.1}]}"#,
    );
    let state = client.until("state", |state| state["lanes"][1].is_object());
    assert_eq!(state["lanes"][1]["damping_n_s_per_m"], 0.1);
    for lane in [0, 1] {
        let frame = client.frame(|frame| frame.run == 2 && frame.lane == lane);
        assert!((frame.column(DEVICE)[0] + 0.05).abs() < 0.01, "lane {lane}");
    }
    // Another method in the same renderings does not restart the loop.
    client.say(r#"{"type":"set","lanes":[{"method":"seh"},{"method":"coupled"}]}"#);
    client.until("state", |state| state["lanes"][0]["method"] == "seh");
    assert_eq!(client.frame(|frame| frame.lane == 0).run, 2);
    client.say(r#"{"type":"restart"}"#);
    client.frame(|frame| frame.run == 3 && frame.lane == 1);
    client.is_well();
}

#[test]
fn safety_stop_is_reported_and_ends_on_rearm() {
    let infinite = f64::INFINITY;
    let stage = Stage::new(Play {
        workspace: Some([[-0.03, -infinite, -infinite], [0.03, infinite, infinite]]),
        ..Play::default()
    });
    let mut client = stage.client();
    client.say(r#"{"type":"hand","position_m":-0.06}"#);
    let safety_stop = "the device left its workspace";
    let state = client.until("state", |state| {
        state["lanes"][0]["safety_stop"].is_string()
    });
    assert_eq!(state["lanes"][0]["safety_stop"], safety_stop);
    client.say(r#"{"type":"hand","position_m":0}"#);
    client.frame(|frame| frame.column(DEVICE).last().unwrap().abs() < 0.01);
    client.say(r#"{"type":"rearm","lane":0}"#);
    client.until("note", |note| note["kind"] == "rearmed");
    // If the machine pauses, late forces may cause another safety stop at once.
    client.until("state", |state| {
        state["lanes"][0]["safety_stop"] != safety_stop
    });
}

/// The server continues without a device, and the loop restarts when there is one.
#[test]
fn a_device_that_is_gone_is_said_and_can_come_back() {
    let stage = Stage::new(Play::default());
    let mut client = stage.client();
    // Clients that have received the greeting receive all later messages.
    client.text("state");
    stage.is_out.store(true, Ordering::Release);
    let ended = client.text("ended");
    assert_eq!(ended["text"], "rendering 1: the device is gone");
    client.until("state", |state| state["lanes"][0]["running"] == false);
    client.say(r#"{"type":"restart"}"#);
    let refused = client.text("refused");
    assert_eq!(refused["text"], "there is no device");
    stage.is_out.store(false, Ordering::Release);
    client.say(r#"{"type":"restart"}"#);
    client.until("state", |state| state["lanes"][0]["running"] == true);
    client.is_well();
}

/// A recording that begins in the middle is a recording like any other.
#[test]
fn a_recording_begins_and_ends_while_the_loop_runs() {
    let stage = Stage::new(Play {
        methods: vec![MethodName::Basic, MethodName::Coupled],
        ..Play::default()
    });
    let mut client = stage.client();
    client.say(r#"{"type":"set","stiffness_n_per_m":321}"#);
    for _lane in 0..2 {
        client.until("note", |note| note["kind"] == "parameters");
    }
    client.say(r#"{"type":"record","on":true}"#);
    let state = client.until("state", |state| state["recording"].is_object());
    let files = &state["recording"]["files"];
    assert_eq!(
        *files,
        json!(["live-001-1-basic.mcap", "live-001-2-coupled.mcap"])
    );
    client.say(r#"{"type":"record","on":true}"#);
    let refused = client.text("refused");
    assert!(refused["text"].as_str().unwrap().contains("end it first"));
    // The ticks in a second frame come after the start of the recording, which therefore has a first tick.
    for lane in [0, 1] {
        for _frame in 0..2 {
            client.frame(|frame| frame.lane == lane);
        }
    }
    client.say(r#"{"type":"set","stiffness_n_per_m":654}"#);
    let status = client.until("status", |status| {
        status["recording"]["ticks"].as_u64() > Some(1000)
    });
    assert_eq!(status["recording"]["lost"], 0);
    assert_eq!(status["recording"]["failed"], Value::Null);
    client.say(r#"{"type":"record","on":false}"#);
    client.until("state", |state| state["recording"].is_null());
    for _ in 0..2 {
        client.until("note", |note| {
            note["kind"] == "recording" && note["text"].as_str().unwrap().contains("is written")
        });
    }
    for (file, method) in files.as_array().unwrap().iter().zip(["basic", "coupled"]) {
        let recording = Recording::open(&stage.folder.path().join(file.as_str().unwrap())).unwrap();
        assert!(recording.is_whole());
        assert_eq!(recording.lost(), 0);
        let metadata = &recording.metadata;
        let scene = &metadata.texts["scene"];
        assert!(scene.contains("stiffness_n_per_m = 321"), "{scene}");
        assert!(scene.contains(&format!("method = \"{method}\"")), "{scene}");
        let mut generations = Vec::new();
        let mut changes = Vec::new();
        for (number, entry) in recording.entries().unwrap().enumerate() {
            match entry.unwrap() {
                Entry::Tick(tick, ..) => {
                    if generations.is_empty() {
                        assert_eq!((tick.sequence, number), (0, 0));
                    }
                    generations.push(tick.generation);
                }
                Entry::Event(event) if event.kind == "parameters" => changes.push(event.text),
                Entry::Event(_) => {}
            }
        }
        assert_eq!((generations[0], generations.last()), (0, Some(&1)));
        // The file also contains the new value.
        assert_eq!(changes.len(), 1, "{changes:?}");
        assert!(changes[0].contains("parameters number 1"), "{changes:?}");
        assert!(changes[0].contains("654 N/m"), "{changes:?}");
    }
    client.say(r#"{"type":"record","on":true}"#);
    let state = client.until("state", |state| state["recording"].is_object());
    assert_eq!(state["recording"]["files"][0], "live-002-1-basic.mcap");
    // Another loop is another recording.
    client.say(r#"{"type":"restart"}"#);
    client.until("note", |note| {
        note["kind"] == "recording" && note["text"].as_str().unwrap().contains("ended with")
    });
    client.until("state", |state| state["recording"].is_null());
}

/// The strongest force of the file is seen by the page: at 4 kHz it sees groups of eight ticks.
#[test]
#[expect(clippy::cast_possible_truncation, reason = "as they are shown")]
fn the_page_sees_every_peak_of_a_fast_loop() {
    let mut fast = scene();
    fast.loop_params.period = 0.000_25;
    let stage = Stage::new(Play {
        scene: fast,
        methods: vec![MethodName::Basic],
        ..Play::default()
    });
    let mut client = stage.client();
    client.say(r#"{"type":"record","on":true}"#);
    client.until("state", |state| state["recording"].is_object());
    client.say(r#"{"type":"hand","position_m":0.03}"#);
    // Of each group its first and last instant, and its two rows.
    let mut groups: Vec<([f64; 2], [f32; 2])> = Vec::new();
    let from = client.frame(|_| true).times[0];
    while groups
        .last()
        .is_none_or(|([_, last], _)| *last < from + 1.0)
    {
        let frame = client.frame(|_| true);
        let times = frame.times.chunks_exact(2);
        let forces = frame.column(FORCE).chunks_exact(2);
        assert!(times.remainder().is_empty(), "a group is two rows");
        groups.extend(
            times
                .zip(forces)
                .map(|(times, forces)| ([times[0], times[1]], [forces[0], forces[1]])),
        );
    }
    client.say(r#"{"type":"record","on":false}"#);
    client.until("note", |note| {
        note["text"].as_str().unwrap().contains("is written")
    });
    let file = stage.folder.path().join("live-001.mcap");
    let forces: Vec<(f64, f64)> = Recording::open(&file)
        .unwrap()
        .entries()
        .unwrap()
        .filter_map(|entry| match entry.unwrap() {
            Entry::Tick(tick, contacts, _, _) => Some((tick.time, contacts[0].force_on_device)),
            Entry::Event(_) => None,
        })
        .collect();
    // Whatever deadlines were missed: the ticks of each group have the extremes that were shown.
    let (mut compared, mut grouped) = (0, 0);
    for ([first, last], shown) in groups.iter().filter(|([first, _], _)| *first > forces[0].0) {
        // A time is sent as a single-precision distance from its frame's first one, so it is exact to
        // 0.1 us. Ticks of a loop that catches up with its deadlines can be some us apart.
        let of_group = |(time, _): &&(f64, f64)| (first - 1e-7..=last + 1e-7).contains(time);
        let ticks: Vec<f32> = forces
            .iter()
            .filter(of_group)
            .map(|tick| tick.1 as f32)
            .collect();
        let least = ticks.iter().copied().fold(f32::INFINITY, f32::min);
        let greatest = ticks.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let shown = [shown[0].min(shown[1]), shown[0].max(shown[1])];
        assert_eq!(shown, [least, greatest], "{first} s to {last} s");
        compared += 1;
        grouped += ticks.len();
    }
    assert!(compared > 30, "{compared}");
    assert!(
        grouped > 2 * compared,
        "{grouped} ticks in {compared} groups"
    );
    assert!(forces.iter().any(|(_, force)| *force < -1.0));
}

#[test]
fn clients_come_and_go_and_are_counted() {
    let stage = Stage::new(Play::default());
    let mut first = stage.client();
    let others: Vec<Client> = (0..3).map(|_| stage.client()).collect();
    first.until("status", |status| status["clients"] == 4);
    drop(others);
    first.until("status", |status| status["clients"] == 1);
}

/// A session that is dropped on an error leaves no force on, and no recording incomplete.
#[test]
fn a_session_that_is_dropped_ends_its_loops_and_recordings() {
    let mut stage = Stage::new(Play::default());
    let mut client = stage.client();
    client.say(r#"{"type":"record","on":true}"#);
    client.until("status", |status| {
        status["recording"]["ticks"].as_u64() > Some(10)
    });
    drop(stage.session.take());
    let recording = Recording::open(&stage.folder.path().join("live-001.mcap")).unwrap();
    assert!(recording.is_whole());
    assert!(!stage.stop.is_raised(), "it was somebody else's");
}

/// Each restart takes a while. Those that wait do not keep the force on.
#[test]
fn restarts_that_wait_do_not_delay_the_end() {
    let mut stage = Stage::new(Play::default());
    let mut client = stage.client();
    for _ in 0..190 {
        client.say(r#"{"type":"restart"}"#);
    }
    client.frame(|frame| frame.run >= 2);
    let begun = Instant::now();
    stage.stop.raise();
    let end = stage.session.take().unwrap().join();
    let took = begun.elapsed();
    assert!(took < Duration::from_secs(1), "{took:?}");
    assert_eq!(end.lanes.len(), 1);
}

#[test]
fn two_methods_on_a_device_with_one_lane_do_not_begin() {
    let refused = Stage::begin(Play {
        methods: vec![MethodName::Basic, MethodName::Coupled],
        most_lanes: 1,
        ..Play::default()
    });
    let error = refused.err().unwrap().to_string();
    assert!(error.contains("in one loop only"), "{error}");
}

/// Nothing comes after it, so there is nothing to wait for.
#[test]
fn a_session_that_was_to_last_ends_with_its_last_device() {
    let mut stage = Stage::new(Play {
        duration: Some(Duration::from_secs(600)),
        ..Play::default()
    });
    let mut client = stage.client();
    client.say(r#"{"type":"record","on":true}"#);
    client.until("status", |status| {
        status["recording"]["ticks"].as_u64() > Some(10)
    });
    stage.is_out.store(true, Ordering::Release);
    let end = stage.session.take().unwrap().join();
    assert_eq!(end.lanes[0].end.ending, palpate_rt::Ending::DeviceLost);
    let written = end.lanes[0].recording.as_ref().unwrap();
    let recording = Recording::open(&written.path).unwrap();
    assert!(recording.is_whole());
    assert_eq!(recording.ticks, *written.ticks.as_ref().unwrap());
    assert!(end.recordings.is_empty());
}

/// Its 500 ticks would take 25 s.
#[test]
fn a_session_that_was_to_last_does_not_wait_for_every_deadline_that_is_missed() {
    let mut stage = Stage::new(Play {
        duration: Some(Duration::from_millis(500)),
        read_takes: Duration::from_millis(50),
        ..Play::default()
    });
    let end = stage.session.take().unwrap().join();
    let lane = &end.lanes[0];
    assert_eq!(lane.end.ending, palpate_rt::Ending::Complete);
    let last = lane.account.last.unwrap().tick.sequence;
    assert!((5..100).contains(&last), "tick {last}");
}

/// The end also reports the recordings made before it.
#[test]
fn session_end_reports_all_recordings_and_failed_start() {
    let mut stage = Stage::new(Play::default());
    let mut client = stage.client();
    for is_on in [true, false, true] {
        client.say(&format!(r#"{{"type":"record","on":{is_on}}}"#));
        client.until("state", |state| state["recording"].is_object() == is_on);
    }
    stage.is_out.store(true, Ordering::Release);
    client.text("ended");
    client.until("state", |state| state["recording"].is_null());
    client.say(r#"{"type":"restart"}"#);
    client.text("refused");
    stage.stop.raise();
    let end = stage.session.take().unwrap().join();
    assert!(end.lanes.is_empty());
    assert_eq!(end.failed.as_deref(), Some("there is no device"));
    let names = end.recordings.iter().map(|written| {
        assert!(written.ticks.is_ok(), "{written:?}");
        written.path.file_name().unwrap().to_str().unwrap()
    });
    assert_eq!(
        names.collect::<Vec<_>>(),
        ["live-001.mcap", "live-002.mcap"]
    );
}
