//! `trochoid render --certificate --error` and `trochoid verify`.

use crate::scene::{READS, SCENE, Scene};
use serde_json::Value;
use std::fs;
use trochoid::io::{Limits, PngImage, Samples, Selection, read, write_png8};

const CERTIFIED: &[&str] = &[
    "render",
    "a.json",
    "--frames",
    "1-2",
    "--certificate",
    "cert/{output}.##.json",
    "--error",
    "err/{output}.####.exr",
];

fn json(scene: &Scene, name: &str) -> Value {
    serde_json::from_slice(&fs::read(scene.path(name)).unwrap()).unwrap()
}

#[test]
fn every_image_has_a_certificate_that_holds() {
    let scene = Scene::new(SCENE);
    let run = scene.run(CERTIFIED).code(0).says(&["hull, 0 outside, display error ≤ ", "nothing ambiguous, "]);
    assert_eq!(run.err, "");
    assert_eq!(scene.files().len(), 12, "{:?}", scene.files());
    for (output, image) in [("beauty", "exr"), ("mask", "png")] {
        for frame in [1, 2] {
            let certificate = format!("cert/{output}.0{frame}.json");
            let image = format!("out/{output}.000{frame}.{image}");
            let run = scene.run(&["verify", &certificate, &image]).code(0);
            run.says(&[
                &certificate,
                "matches its own digest",
                &format!("of frame {frame}"),
                "the certified pixels, in 1 block\n",
                "all 128 pixels derived again",
                "every pixel was looked at",
                "\nholds\n",
            ]);
            scene.run(&["verify", &certificate, &image, "--quiet", "--all", "--document", "a.json"]).code(0);
        }
    }
    let json = scene.run(&["verify", "cert/beauty.01.json", "out/beauty.0001.exr", "--pixels", "9", "--json"]).code(0);
    let json = json.json();
    assert_eq!(
        (json["holds"].as_bool(), json["frame"].as_i64(), json["blocks"].as_i64()),
        (Some(true), Some(1), Some(1))
    );
    let looked_at = json["outputs"][0]["looked_at"].as_i64().unwrap();
    assert!((9..20).contains(&looked_at), "9, and those that the certificate names: {looked_at}");
    assert_eq!(json["outputs"][0]["hull"], true);
    // 1 − 0.01^(1/9).
    assert!((json["share_found"].as_f64().unwrap() - 0.400_5).abs() < 1e-4, "{json}");
}

#[test]
fn a_seed_is_drawn_and_printed_and_repeats_a_run() {
    let scene = Scene::new(SCENE);
    scene.run(CERTIFIED).code(0);
    let verify = |more: &[&str]| {
        let (certificate, image) = ("cert/beauty.01.json", "out/beauty.0001.exr");
        scene.run(&[&["verify", certificate, image, "--pixels", "20"], more].concat())
    };
    let run = verify(&[]).code(0);
    let words = "if 21 % of the pixels had been changed, wherever they are, one of them would have been looked at with a \
                 probability of 99 %; seed ";
    let run = run.says(&[words]);
    let seed = run.out.split("seed ").nth(1).unwrap()[..16].to_string();
    assert_eq!(verify(&["--seed", &seed]).code(0).out, run.out);
    let other = verify(&[]).code(0);
    assert!(!other.out.contains(&seed), "each run draws its own: {}", other.out);
    assert_eq!(verify(&["--seed", &seed, "--json"]).code(0).json()["seed"], seed.as_str());
    verify(&["--seed", "x"]).fails(2, &["--seed", "hexadecimal digits"]);
}

#[test]
fn the_certificate_says_what_is_certain() {
    let scene = Scene::new(&SCENE.replace("\"height\": 8", "\"height\": 8, \"samples\": 4"));
    scene.run(&[CERTIFIED, &["--require", "box", "--set", "mix.a=#100"]].concat()).code(0);
    let certificate = json(&scene, "cert/beauty.02.json");
    assert_eq!(certificate["frame"], 2);
    assert_eq!(certificate["document"]["canonical"]["nodes"]["mix"]["a"], "#100");
    assert_eq!(certificate["document"]["folder"], "..");
    assert_eq!(certificate["image"]["file"], "../out/beauty.0002.exr");
    let names: Vec<&str> =
        certificate["plan"].as_array().unwrap().iter().map(|n| n["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["across", "mix"]);
    let beauty = &certificate["outputs"][0];
    assert_eq!(beauty["guarantee"], serde_json::json!({ "class": "hull", "held": "hull", "required": "hull" }));
    assert_eq!((beauty["controls"]["corners"].as_i64(), beauty["counts"]["outside"].as_i64()), (Some(2), Some(0)));
    let bounds = &beauty["error"]["channels"][0];
    assert_eq!((&bounds["all"], bounds["all"]["bounded"].as_i64()), (&bounds["clear"], Some(128)));
    let max = bounds["all"]["max"]["bound"].as_f64().unwrap();
    assert!(max > 0.0 && max < 1e-6, "{max}");
    let shown = beauty["error"]["display"]["all"]["max"]["bound"].as_f64().unwrap();
    assert!(shown > 0.0 && shown < 1e-6, "{shown}");
    let error = read(scene.path("err/beauty.0002.exr"), &Selection::layer("error"), &Limits::default()).unwrap();
    let names: Vec<&str> = error.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["R", "G", "B"]);
    let largest = error.channels.iter().flat_map(|c| c.plane.samples()).fold(0.0_f32, |most, error| most.max(*error));
    let (largest, level) = (f64::from(largest), 2.0_f64.powf(0.125));
    assert!(largest <= max && max < largest * level, "{max} is {largest}, rounded up to an eighth of an octave");
    let doubt = read(scene.path("err/mask.0001.exr"), &Selection::channels(["doubt", "error.Y"]), &Limits::default());
    assert!(doubt.unwrap().channels[0].plane.samples().iter().all(|doubt| *doubt == 0.0));
}

#[test]
fn reports_name_the_files_and_the_errors() {
    let scene = Scene::new(SCENE);
    scene.run(&[CERTIFIED, &["--report", "r.json", "--quiet"]].concat()).code(0);
    let frame = &json(&scene, "r.json")["frames"][1];
    assert_eq!(frame["files"][0]["certificate"], "cert/beauty.02.json");
    assert_eq!(frame["files"][1]["error"], "err/mask.0002.exr");
    let certified = &frame["outputs"]["beauty"]["certified"];
    assert!(certified["clear"]["max"].as_f64().unwrap() < 1e-6 && certified["ambiguous_share"] == 0.0, "{certified}");
    assert_eq!((&certified["all"], certified["clear"]["samples"].as_i64()), (&certified["clear"], Some(128)));
    assert_eq!(certified["unit"], "channel of a color in linear-srgb");
    assert!(certified["all"]["displayed_max"].as_f64().unwrap() < 1e-5);
    let mask = &frame["outputs"]["mask"]["certified"];
    assert_eq!((&mask["unit"], &mask["all"]["displayed_max"]), (&"weight from 0 to 1".into(), &mask["all"]["max"]));
    assert!(frame["seconds"]["certify"].as_f64().unwrap() > 0.0);
}

#[test]
fn resume_takes_no_image_for_done_without_its_certificate() {
    let scene = Scene::new(SCENE);
    let resume = [CERTIFIED, &["--resume"]].concat();
    let current = || scene.run(&resume).code(0).out.lines().map(|l| l.ends_with("up to date")).collect::<Vec<_>>();
    scene.run(&["render", "a.json"]).code(0);
    assert_eq!(current(), [false, false]);
    assert_eq!(current(), [true, true]);
    fs::remove_file(scene.path("err/mask.0001.exr")).unwrap();
    let text = fs::read_to_string(scene.path("cert/beauty.02.json")).unwrap();
    fs::write(scene.path("cert/beauty.02.json"), text.replace("\"frame\": 2", "\"frame\": 3")).unwrap();
    let run = scene.run(&resume).code(0);
    assert!(run.out.starts_with("frame 1: mask → ") && run.out.contains("\nframe 2: beauty → "), "{}", run.out);
    assert_eq!(current(), [true, true]);
    assert_eq!(scene.run(&["render", "a.json", "--resume"]).code(0).out.matches("up to date").count(), 3);
}

#[test]
fn patterns_that_give_two_files_one_name_or_name_files_in_use_are_refused() {
    let scene = Scene::new(SCENE);
    let refused = |more: &[&str], words: &[&str]| {
        scene.run(&[&["render", "a.json"], more].concat()).fails(2, words);
        scene.has_no_files();
    };
    let patterns = ["\"c.json\" gives 2 files one name", "\"c.json\" gives all frames one name"];
    refused(&["--certificate", "c.json"], &patterns);
    refused(&["--error", "{outputs}.exr"], &["unknown placeholder {outputs}"]);
    refused(&["--certificate", "{output}.##.txt"], &["another extension than .json"]);
    let one = ["--frames", "1", "--output", "beauty"];
    refused(&[&one[..], &["--certificate", "a.json"]].concat(), &["--certificate a.json: is a file of the document"]);
    refused(&[&one[..], &["--error", "out/beauty.0001.exr"]].concat(), &["--error out/beauty.0001.exr: is a file"]);
    let taken = ["--certificate", "c.json", "--report", "c.json"];
    refused(&[&one[..], &taken].concat(), &["--report c.json: is a file"]);
}

#[test]
fn what_does_not_hold_is_code_3_and_named() {
    let scene = Scene::new(SCENE);
    scene.run(CERTIFIED).code(0);
    let (certificate, image) = ("cert/mask.01.json", "out/mask.0001.png");
    let verify = |certificate: &str, image: &str, words: &[&str]| {
        scene.run(&["verify", certificate, image]).fails(3, words);
        let json = scene.run(&["verify", certificate, image, "--json"]).code(3);
        assert!(json.json()["holds"] == false && json.err.is_empty(), "{}", json.err);
    };
    verify("cert/beauty.01.json", image, &["error: out/mask.0001.png: kind of file", "does not hold for out/mask"]);
    let text = fs::read_to_string(scene.path(certificate)).unwrap();
    fs::write(scene.path("c.json"), text.replace("\"frame\": 1", "\"frame\": 2")).unwrap();
    verify("c.json", image, &["error: c.json: digest: found ", "has been changed"]);
    let mut picture = read(scene.path(image), &Selection::default(), &Limits::default()).unwrap();
    picture.channels[0].plane.samples_mut()[19] += 1.0 / 255.0;
    let changed = PngImage::new(16, 8, [Samples::plane(&picture.channels[0].plane)]);
    write_png8(scene.path("b.png"), &changed).unwrap();
    verify(certificate, "b.png", &["error: b.png: block 0, x 0 to 15, y 0 to 7: found pixels of hash "]);
    let other = SCENE.replace("#fff", "#ffe");
    fs::write(scene.path("b.json"), other).unwrap();
    let words = ["error: b.json: hash of the document"];
    scene.run(&["verify", certificate, image, "--document", "b.json"]).fails(3, &words);
    scene.run(&["verify", certificate, image, "--document", "b.json", "--set", "mix.b=#fff"]).code(0);
}

#[test]
fn files_that_cannot_be_read_have_their_own_codes() {
    let scene = Scene::new(READS);
    scene.write_picture("in.exr", 0.25);
    scene.run(&["render", "a.json", "--certificate", "c.json"]).code(0);
    scene.run(&["verify", "c.json", "out.exr"]).code(0).says(&["its input file is the same"]);
    scene.run(&["verify", "none.json", "out.exr"]).fails(1, &["none.json: cannot open the file"]);
    scene.run(&["verify", "c.json", "none.exr"]).fails(1, &["none.exr"]);
    scene
        .run(&["verify", "out.exr", "c.json"])
        .fails(2, &["c.json: found a certificate; expected an image in second place"]);
    scene.run(&["verify", "a.json", "out.exr"]).fails(2, &["a.json: found JSON that does not begin with a digest"]);
    scene.run(&["verify", "c.json", "out.exr", "--all", "--pixels", "3"]).fails(2, &["cannot be used with"]);
    // A check that evaluates nothing would hold for any pixels.
    scene.run(&["verify", "c.json", "out.exr", "--pixels", "0"]).fails(2, &["--pixels", "0 is not in 1.."]);
    scene.write_picture("in.exr", 0.5);
    let run = scene.run(&["verify", "./c.json", "out.exr"]);
    assert!(
        run.err.contains("error: in.exr: input: found ") && run.err.contains(" bytes with the hash "),
        "{}",
        run.err
    );
    run.fails(3, &["./c.json: does not hold for out.exr"]);
    fs::remove_file(scene.path("in.exr")).unwrap();
    scene.run(&["verify", "c.json", "out.exr"]).fails(1, &["in.exr: cannot open the file"]);
    // A certificate that was moved.
    fs::create_dir(scene.path("sub")).unwrap();
    fs::rename(scene.path("c.json"), scene.path("sub/c.json")).unwrap();
    let words = [
        "sub/in.exr: cannot open",
        "an input of the certificate",
        "sought from the certificate's folder, sub\n  remedy: put",
    ];
    scene.run(&["verify", "sub/c.json", "out.exr"]).fails(1, &words);
}

#[test]
fn an_image_of_another_kind_is_described_as_it_is() {
    let scene = Scene::new(SCENE);
    let one = ["render", "a.json", "--frames", "1", "--output", "beauty", "--out"];
    scene.run(&[&one[..], &["x.png", "--certificate", "c.json"]].concat()).code(0);
    scene.run(&[&one[..], &["x.exr"]].concat()).code(0);
    let run = scene.run(&["verify", "c.json", "x.exr"]);
    assert!(!run.err.contains("image.channels"), "the certificate is right in itself: {}", run.err);
    let channels = "x.exr: channels: found B (half), G (half), R (half); expected B (u8), G (u8), R (u8)";
    run.fails(3, &["x.exr: kind of file: found EXR; expected PNG", channels]);
}

/// Keys of RFC 8410, 10.1 and 10.3, as OpenSSL writes them.
const PRIVATE: &str = "-----BEGIN PRIVATE KEY-----\n\
    MC4CAQAwBQYDK2VwBCIEINTuctv5E1hK1bbY8fdp+K06/nwoy/HU++CXqI9EdVhC\n-----END PRIVATE KEY-----\n";
const PUBLIC: &str = "-----BEGIN PUBLIC KEY-----\n\
    MCowBQYDK2VwAyEAGb9ECWmEzf6FQbrBZ9w7lshQhqowtrbLDFw4rXAxZuE=\n-----END PUBLIC KEY-----\n";
/// Another public key, of RFC 8032, 7.1, test 1.
const OTHER: &str = "-----BEGIN PUBLIC KEY-----\n\
    MCowBQYDK2VwAyEA11qYAYKxCrfVS/7TyWQHOg7hcvPapiMlrwIaaPcHURo=\n-----END PUBLIC KEY-----\n";

#[test]
fn certificates_are_signed_and_whose_they_are_is_told() {
    let scene = Scene::new(SCENE);
    for (name, text) in [("mine.pem", PRIVATE), ("mine.pub.pem", PUBLIC), ("other.pub.pem", OTHER)] {
        fs::write(scene.path(name), text).unwrap();
    }
    let (certificate, image) = ("cert/beauty.01.json", "out/beauty.0001.exr");
    let verify = |more: &[&str]| scene.run(&[&["verify", certificate, image], more].concat());
    scene.run(CERTIFIED).code(0);
    verify(&[]).code(0).says(&["it is not signed, so anyone may have made it"]);
    let key = "19bf44096984cdfe8541bac167dc3b96c85086aa30b6b6cb0c5c38ad703166e1";
    let missing = format!("{certificate}: signature: found no signature; expected one by {key}");
    verify(&["--key", "mine.pub.pem"]).fails(3, &[&missing]);
    // Unsigned certificates are not those that were asked for.
    let sign = [CERTIFIED, &["--sign", "mine.pem", "--resume"]].concat();
    assert!(!scene.run(&sign).code(0).out.contains("up to date"));
    assert_eq!(scene.run(&sign).code(0).out.matches("up to date").count(), 2);
    assert_eq!(json(&scene, certificate)["signature"]["key"], key);
    verify(&[]).code(0).says(&[&format!("signed by the key {key}; --key tells whether that is a key that you know")]);
    verify(&["--key", "mine.pub.pem"]).code(0).says(&[&format!("it is signed by the key {key}\n")]);
    assert_eq!(verify(&["--key", "mine.pub.pem", "--json"]).code(0).json()["signed_by"], key);
    verify(&["--key", "other.pub.pem"]).fails(3, &[&format!("found one by {key}; expected one by d75a980182b10ab7")]);
    verify(&["--key", "mine.pem"]).fails(2, &["mine.pem: found a private key; expected an Ed25519 public key"]);
    let run = scene.run(&[CERTIFIED, &["--sign", "mine.pub.pem"]].concat());
    run.fails(2, &["mine.pub.pem: found a public key; expected an unencrypted Ed25519 private key", "openssl genpkey"]);
    scene.run(&["render", "a.json", "--sign", "mine.pem"]).fails(2, &["--certificate"]);
    let shown = scene.run(&sign);
    assert!(!(shown.out + &shown.err).contains("MC4CAQ"), "the private key is never shown");
}
