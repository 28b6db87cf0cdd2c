//! The command line of a long render makes the picture that is shown, to the bit.

use crate::viewer::{Viewer, shell, status, wait_for};
use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};
use serde_json::{Value, json};
use std::path::Path;
use tungstenite::Message;

/// Why a picture is compared, what its settings change, and what is asked for then.
type Case<'a> = (&'a str, &'a [(&'a str, Value)], &'a [Value]);

/// Returns the channels R, G, B and A as bits.
fn bits(path: &Path) -> Vec<(String, Vec<u32>)> {
    let image = read_first_flat_layer_from_file(path).expect("an EXR");
    let channels = image.layer_data.channel_data.list.into_iter();
    let channels = channels.filter(|channel| channel.name.to_string().len() == 1);
    let bits = |samples: FlatSamples| match samples {
        FlatSamples::F32(samples) => samples.iter().map(|value| value.to_bits()).collect(),
        other => panic!("{other:?}"),
    };
    channels.map(|channel| (channel.name.to_string(), bits(channel.sample_data))).collect()
}

/// Shows a picture with these settings, and compares it with the one that its command makes.
#[track_caller]
fn check(viewer: &Viewer, why: &str, changes: &[(&str, Value)], requests: &[Value]) {
    let mut socket = viewer.socket();
    let greeting: Value =
        serde_json::from_str(&wait_for(&mut socket, "greeting")).expect("a greeting");
    let mut settings = json!({ "samples": 3 });
    for (name, value) in changes {
        settings[name] = value.clone();
    }
    let size = json!({ "type": "size", "width": 75, "height": 52, "keep_aspect": false });
    let settings = json!({ "type": "settings", "settings": settings });
    for request in [&[size, settings], requests].concat() {
        socket.send(Message::text(request.to_string())).expect("an open socket");
    }
    wait_for(&mut socket, r#""activity":"done""#);
    let get = |file: &str| {
        let answer =
            viewer.get_bytes(&format!("/{}/save/{}/{file}", viewer.token, greeting["session"]));
        let text = String::from_utf8_lossy(&answer);
        assert_eq!(status(&text), "200", "{why}: {text}");
        let head = answer.windows(4).position(|it| it == b"\r\n\r\n").expect("a head");
        answer[head + 4..].to_vec()
    };
    let folder = viewer.folder.path();
    let line = String::from_utf8(get("command")).expect("a text");
    let other = line.replacen(".png", ".exr", 1);
    assert_ne!(line, other, "{why}: the command writes a PNG");
    shell(folder, &other);
    std::fs::write(folder.join("shown.exr"), get("picture.exr")).expect("writes");
    let rendered = other.split("--out ").nth(1).and_then(|rest| rest.split(' ').next());
    let rendered = bits(&folder.join(rendered.expect("a file").trim_matches('\'')));
    let shown = bits(&folder.join("shown.exr"));
    assert_eq!(shown.len(), 4, "{why}");
    assert_eq!(shown[0].1.len(), 75 * 52, "{why}");
    assert!(shown == rendered, "{why}: another picture by {line}");
}

#[test]
fn the_command_makes_what_is_shown_of_a_lone_file() {
    let viewer = Viewer::start(&["--radius", "0.3", "--up", "y"]);
    let moved = json!({ "type": "move", "orbit": [0.2, 0.1], "zoom": 0.4, "pan": [0.03, -0.02] });
    let table: [Case<'_>; 4] = [
        ("as it is", &[], &[]),
        ("without the background", &[("background", json!(false))], &[]),
        ("by another method", &[("points", json!(false))], &[]),
        ("from elsewhere, in front of nothing", &[("background", json!(false))], &[moved]),
    ];
    for (why, changes, requests) in table {
        check(&viewer, why, changes, requests);
    }
}

#[test]
fn the_command_makes_what_is_shown_of_a_scene() {
    let viewer = Viewer::of("shapes4", &[]);
    let grab = json!({ "type": "grab", "at": [0.4, 0.6] });
    let moved = json!({ "type": "move", "orbit": [0.3, -0.1], "fly": [0.1, 0.0, 0.2] });
    let focus = json!({ "type": "focus", "at": [0.5, 0.5] });
    let table: [Case<'_>; 8] = [
        ("as it is", &[], &[]),
        ("moved", &[], &[grab, moved, json!({ "type": "release" })]),
        ("in focus", &[], &[focus]),
        (
            "vanilla",
            &[("points", json!(false)), ("lines", json!(false)), ("quads", json!(false))],
            &[json!({ "type": "frame-all" })],
        ),
        ("lines alone exact", &[("points", json!(false)), ("quads", json!(false))], &[]),
        ("bodies apart", &[("overlap", json!("separate"))], &[]),
        (
            "otherwise sampled, in front of nothing",
            &[
                ("background", json!(false)),
                ("overlap", json!("union")),
                ("independent", json!(true)),
                ("seed", json!(7)),
                ("bounces", json!(3)),
                ("clamp", json!(1.7)),
            ],
            &[],
        ),
        ("a view", &[("view", json!("error"))], &[]),
    ];
    for (why, changes, requests) in table {
        check(&viewer, why, changes, requests);
    }
}
