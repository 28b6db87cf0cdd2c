//! A render that is interrupted, killed or divided into shards gives the picture of an
//! uninterrupted one.

use rotund_trace::output::load_film;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

const SCENE: &str = r#"{
    "asset": { "version": "4.2" },
    "cameras": [{ "name": "front", "frame": [1,0,0, 0,1,0, 0,0,1, 0,0,2] }],
    "environments": [{ "emission": [0.2, 0.5, 1] }],
    "materials": [
        { "name": "grey", "type": "glossy", "roughness": 0.3, "color": [0.5, 0.5, 0.5] },
        { "name": "lamp", "emission": [5, 4, 3] }
    ],
    "shapes": [{ "name": "floor", "uri": "floor.ply" }, { "name": "ball", "uri": "ball.ply" }],
    "instances": [
        { "name": "floor", "shape": 0, "material": 0 }, { "name": "ball", "shape": 1, "material": 1 }
    ]
}"#;
const FLOOR: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    -1 -0.4 -1\n1 -0.4 -1\n1 -0.3 1\n-1 -0.4 1\n4 0 1 2 3\n";
const BALL: &str = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
    property float z\nproperty float radius\nelement point 1\n\
    property list uchar int vertex_indices\nend_header\n0 0 0 0.2\n1 0\n";

/// A folder with the scene, in which the program runs.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (name, text) in [("scene.json", SCENE), ("floor.ply", FLOOR), ("ball.ply", BALL)] {
            fs::write(folder.path().join(name), text).expect("a file of the scene");
        }
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rotund"));
        command.current_dir(self.0.path()).args(arguments.split_whitespace());
        command
    }

    /// Runs the program to its end.
    fn run(&self, arguments: &str) -> Output {
        self.command(arguments).output().expect("the program starts")
    }

    #[track_caller]
    fn succeed(&self, arguments: &str) {
        let output = self.run(arguments);
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{arguments}: {message}");
    }

    /// Asserts that a run ends with this code and says all of the words.
    #[track_caller]
    fn end(&self, arguments: &str, code: i32, words: &[&str]) {
        let output = self.run(arguments);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments}: {message}");
        for word in words {
            assert!(message.contains(word), "{arguments}: {word:?} is not in {message:?}");
        }
    }

    #[track_caller]
    fn refuse(&self, arguments: &str, words: &[&str]) {
        let output = self.run(arguments);
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(matches!(output.status.code(), Some(1 | 2)), "{arguments}: {message}");
        for word in words {
            assert!(message.contains(word), "{arguments}: {word:?} is not in {message:?}");
        }
    }

    /// Starts the program, and returns as soon as `file` exists.
    fn start(&self, arguments: &str, file: &str) -> Child {
        let mut command = self.command(arguments);
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
        let child = child.expect("the program starts");
        self.await_file(file);
        child
    }

    fn await_file(&self, file: &str) {
        let start = Instant::now();
        while !self.path(file).exists() {
            assert!(start.elapsed() < Duration::from_secs(60), "{file} is not written");
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

const PICTURE: &str = "render scene.json --resolution 48 --samples 3000 --seed 7";

fn samples(path: &Path) -> u32 {
    load_film(path).expect("a checkpoint").samples()
}

#[test]
fn a_render_that_was_killed_goes_on_to_the_same_picture() {
    let place = Place::new();
    place.succeed(&format!("{PICTURE} --out plain.exr"));
    let kept = format!("{PICTURE} --out kept.exr --checkpoint film --checkpoint-every 0 --resume");
    let mut child = place.start(&kept, "film");
    child.kill().expect("it runs");
    child.wait().expect("it ends");
    assert!(!place.path("kept.exr").exists(), "it was not finished");
    let done = samples(&place.path("film"));
    assert!((1..3000).contains(&done), "{done} samples");
    place.succeed(&kept);
    assert_eq!(samples(&place.path("film")), 3000);
    assert!(place.bytes("plain.exr") == place.bytes("kept.exr"), "the pictures differ");
}

#[cfg(unix)]
#[test]
fn a_signal_writes_the_samples_so_far_and_says_how_many() {
    let place = Place::new();
    place.succeed(&format!("{PICTURE} --out plain.exr"));
    let kept = format!("{PICTURE} --out kept.exr --checkpoint film --checkpoint-every 0 --resume");
    for signal in ["INT", "TERM", "HUP"] {
        let child = place.start(&kept, "film");
        send(&child, signal);
        let output = child.wait_with_output().expect("it ends");
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(130), "{signal}: {message}");
        let done = samples(&place.path("film"));
        assert!((1..3000).contains(&done), "{done} samples");
        let expected = format!("error: interrupted; kept.exr and film: {done} of 3000 samples");
        assert!(message.contains(&expected), "{expected:?} is not in {message:?}");
        assert!(place.path("kept.exr").exists(), "a picture is written");
        fs::rename(place.path("film"), place.path("last")).expect("the checkpoint");
    }
    fs::rename(place.path("last"), place.path("film")).expect("the checkpoint");
    place.succeed(&kept);
    assert!(place.bytes("plain.exr") == place.bytes("kept.exr"), "the pictures differ");
}

#[cfg(target_os = "linux")]
#[test]
fn a_hangup_that_nohup_ignores_stays_ignored() {
    let place = Place::new();
    let program = env!("CARGO_BIN_EXE_rotund");
    let line = format!("exec nohup {program} {PICTURE} --checkpoint film --checkpoint-every 0");
    let mut command = Command::new("sh");
    command.current_dir(place.0.path()).args(["-c", &line]).stdin(Stdio::null());
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("sh");
    place.await_file("film");
    send(&child, "HUP");
    let output = child.wait_with_output().expect("it ends");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[cfg(unix)]
#[test]
fn ctrl_c_in_a_comparison_keeps_the_picture_that_was_begun() {
    let place = Place::new();
    let command = "compare scene.json --out there --resolution 64 --samples 100000";
    let child = place.start(command, "there");
    // The folder exists shortly before the handler of Ctrl-C is installed.
    std::thread::sleep(Duration::from_millis(500));
    send(&child, "INT");
    let output = child.wait_with_output().expect("it ends");
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{message}");
    assert!(message.contains("there holds vanilla with "), "{message}");
    assert!(message.contains(" of 100000 samples"), "{message}");
    assert!(place.path("there/vanilla.exr").exists(), "a picture is written");
}

#[cfg(unix)]
fn send(child: &Child, signal: &str) {
    let status = Command::new("kill").args(["-s", signal, &child.id().to_string()]).status();
    assert!(status.expect("kill starts").success(), "the program runs");
}

#[test]
fn shards_merge_to_the_picture_of_one_render() {
    let place = Place::new();
    // The size gives more than one tile of the EXR file in each direction.
    let picture = "render scene.json --resolution 160 --samples 10 --seed 7";
    place.succeed(&format!("{picture} --out plain.exr"));
    for shard in 1..=3 {
        place.succeed(&format!("{picture} --shard {shard}/3 --checkpoint {shard}.film"));
    }
    place.succeed("merge 3.film 1.film 2.film --out merged.exr");
    assert!(place.bytes("plain.exr") == place.bytes("merged.exr"), "the pictures differ");
    place.end("merge 1.film 2.film --out no.exr", 4, &["1 of 3 shards are missing", "3/3"]);
    place.end("merge 1.film 2.film 2.film --out no.exr", 1, &["shard 2/3 is there 2 times"]);
    let other = "render scene.json --resolution 160 --seed 8 --samples 10";
    place.succeed(&format!("{other} --shard 2/3 --checkpoint other.film"));
    // The odd film is named, wherever it stands.
    for films in ["1.film other.film 3.film", "other.film 1.film 3.film"] {
        place.end(
            &format!("merge {films} --out no.exr"),
            1,
            &["other.film is of another picture than 1.film: seed 8, not seed 7"],
        );
    }
    place.end("merge 1.film 3.film --out 1.film --partial", 1, &["--out would replace 1.film"]);
    assert!(!place.path("no.exr").exists(), "nothing is written");
}

#[test]
fn merges_nest_show_what_there_is_and_take_more_samples() {
    let place = Place::new();
    let picture = "render scene.json --resolution 64 --seed 7";
    let shard = |shard: u32, samples: u32| {
        format!("{picture} --samples {samples} --shard {shard}/4 --checkpoint f-{{shard}}.film")
    };
    for index in 1..=4 {
        place.succeed(&shard(index, 12));
    }
    place.succeed("merge f-1.film f-3.film --partial --out a.film");
    place.succeed("merge f-2.film f-4.film --partial --out b.film");
    let half = place.run("merge a.film --partial --out preview.png");
    let said = String::from_utf8_lossy(&half.stdout).into_owned();
    assert!(said.contains("6 of 12 samples of 1 films; shards 1 and 3 of 4 alone"), "{said}");
    place.end("merge a.film f-2.film --out no.exr", 4, &["1 of 4 shards are missing", "4/4"]);
    place.end("merge a.film f-3.film --partial --out no.exr", 1, &["in a.film, f-3.film"]);
    place.refuse(&format!("{picture} --samples 12 --checkpoint a.film --resume"), &["4 shards"]);
    place.succeed("merge a.film b.film --out whole.film");
    place.succeed("merge whole.film --out whole.exr");
    place.succeed(&format!("{picture} --samples 12 --out plain.exr"));
    assert!(place.bytes("plain.exr") == place.bytes("whole.exr"), "the pictures differ");
    place.succeed(&format!("{picture} --samples 20 --out plain.exr"));
    let more = format!("{picture} --samples 20 --checkpoint whole.film --resume --out more.exr");
    place.succeed(&more);
    assert!(place.bytes("plain.exr") == place.bytes("more.exr"), "the pictures differ");
    // One shard was asked for more samples than the others.
    place.succeed(&format!("{} --resume", shard(4, 20)));
    place.end(
        "merge f-1.film f-2.film f-3.film f-4.film --out no.exr",
        1,
        &["f-4.film is of another picture than f-1.film: 20 samples, not 12 samples"],
    );
}

#[cfg(unix)]
#[test]
fn an_unfinished_shard_is_called_so() {
    let place = Place::new();
    let shard = format!("{PICTURE} --shard 1/1 --checkpoint a.film --checkpoint-every 0");
    let mut child = place.start(&shard, "a.film");
    child.kill().expect("it runs");
    child.wait().expect("it ends");
    place.end("merge a.film --out no.exr", 4, &["not finished: a.film (", " of 3000 samples)"]);
    place.succeed("merge a.film --partial --out preview.exr");
}

#[cfg(unix)]
#[test]
fn a_checkpoint_that_cannot_be_written_does_not_cost_the_picture() {
    use std::os::unix::fs::symlink;
    let place = Place::new();
    fs::create_dir(place.path("gone")).expect("a folder");
    symlink("gone", place.path("far")).expect("a link");
    for (interrupted, code, words) in [
        (true, 130, "error: interrupted; a.png: "),
        (false, 3, "far/film: its folder cannot be written to: entity not found: the picture"),
    ] {
        let kept = format!("{PICTURE} --out a.png --checkpoint far/film --checkpoint-every 0");
        let child = place.start(&kept, "far/film");
        // The folder disappears while the program renders.
        fs::rename(place.path("gone"), place.path("moved")).expect("the folder");
        if interrupted {
            send(&child, "INT");
        }
        let output = child.wait_with_output().expect("it ends");
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{message}");
        assert!(message.contains("warning: cannot write far/film"), "{message}");
        assert!(message.contains(words) && message.lines().count() <= 4, "{message}");
        fs::remove_file(place.path("a.png")).expect("the picture is written");
        fs::remove_file(place.path("moved/film")).expect("an early checkpoint");
        fs::rename(place.path("moved"), place.path("gone")).expect("the folder");
    }
}

#[test]
fn an_output_that_would_replace_another_file_is_refused() {
    let place = Place::new();
    let render = "render scene.json --resolution 16 --samples 1";
    place.end(
        &format!("{render} --out a.png --checkpoint ./a.png"),
        1,
        &["--out and --checkpoint are both ./a.png"],
    );
    place.end(
        &format!("{render} --checkpoint scene.json --resume"),
        1,
        &["--checkpoint would replace scene.json, which is read"],
    );
    place.end(&format!("{render} --checkpoint ball.ply --resume"), 1, &["would replace ball.ply"]);
    place.succeed(&format!("{render} --out a.png"));
    let textured = SCENE.replace(
        "\"environments\": [{",
        "\"textures\": [{ \"uri\": \"a.png\" }], \"environments\": [{ \"emission_tex\": 0,",
    );
    fs::write(place.path("scene.json"), textured).expect("a file");
    place.end(&format!("{render} --out a.png"), 1, &["--out would replace a.png"]);
    place.end("diff a.png a.png --signed-map a.png", 1, &["--signed-map would replace a.png"]);
    place.end(&format!("{render} --out {{shard}}.png"), 1, &["there is no --shard"]);
}

#[test]
fn a_checkpoint_that_does_not_fit_is_refused_in_a_sentence() {
    let place = Place::new();
    let picture = "render scene.json --resolution 32 --samples 4 --checkpoint film";
    place.succeed(picture);
    place.refuse(picture, &["film exists", "--resume"]);
    for (change, words) in [
        ("--seed 9", ["seed 0", "seed 9"]),
        ("--bounces 3", ["8 bounces", "3 bounces"]),
        ("--resolution 40", ["32 x ", "40 x "]),
        ("--mode vanilla", ["points enhanced", "not scene, camera"]),
        ("--kinds lines", ["points enhanced", "points vanilla"]),
        ("--overlap separate", ["points enhanced (", "points enhanced (separate)"]),
        ("--out a.exr --layers", ["another picture", "layers"]),
        ("--sampler independent", ["another picture", "independent numbers"]),
        ("--clamp 10", ["another picture", "clamped to 10"]),
        ("--transparent", ["another picture", ", transparent background"]),
        ("--view uv", ["another picture", "view uv"]),
        ("--shard 1/2", ["another picture", "1 shards, not 2"]),
        ("--samples 3", ["has 4 samples already", "the 3 asked for"]),
    ] {
        place.refuse(&format!("{picture} --resume {change}"), &words);
    }
    // The label has a hash of the scene, so a change of one coordinate is detected.
    fs::write(place.path("floor.ply"), FLOOR.replace("1 -0.3 1", "1 -0.31 1")).expect("a file");
    place.refuse(&format!("{picture} --resume"), &["but other shapes, materials"]);
    fs::write(place.path("floor.ply"), FLOOR).expect("a file");
    place.succeed(&format!("{picture} --resume"));

    let whole = place.bytes("film");
    fs::write(place.path("film"), &whole[..whole.len() / 2]).expect("a file");
    place.refuse(&format!("{picture} --resume"), &["film is damaged"]);
    fs::write(place.path("film"), "no film").expect("a file");
    place.refuse(&format!("{picture} --resume"), &["film is not a checkpoint"]);
    place.refuse("merge film --out no.exr", &["film is not a checkpoint"]);
    place.refuse("render scene.json --shard 0/4 --checkpoint a", &["1/4 to 4/4"]);
    place.refuse("render scene.json --shard 2/4 --out a.png", &["--checkpoint"]);
}

#[test]
fn every_view_makes_a_picture_and_layers_go_into_an_exr() {
    let place = Place::new();
    let views = "path furnace eyelight position geometric-normal shading-normal uv texcoord \
        element instance method material error";
    for view in views.split_whitespace() {
        let out = format!("{view}.png");
        place.succeed(&format!(
            "render scene.json --resolution 32 --samples 4 --view {view} --out {out}"
        ));
        assert!(place.path(&out).exists(), "{view}");
    }
    place.succeed("render scene.json --resolution 32 --samples 4 --layers --out layers.exr");
    let file = exr::prelude::read_all_flat_layers_from_file(place.path("layers.exr"));
    let layers = file.expect("an EXR").layer_data;
    let names: Vec<_> =
        layers[0].channel_data.list.iter().map(|channel| channel.name.to_string()).collect();
    let expected = "A B G R albedo.B albedo.G albedo.R depth.Z element.id instance.id material.id \
        normal.X normal.Y normal.Z position.X position.Y position.Z";
    assert_eq!(names, expected.split_whitespace().collect::<Vec<_>>());
    place.refuse("render scene.json --layers --out layers.png", &["only an exr"]);
}
