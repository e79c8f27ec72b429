//! The real window, on a display in memory, driven with pointer and keys like by a person.
//!
//! Everything between a key and the saved file is real here: the program, its event loop, the
//! surface it draws on. The same steps in detail are tests of `tests/window`.

#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::HashSet;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use x11rb::connection::Connection as _;
use x11rb::protocol::xproto::{
    self, ConfigureWindowAux, ConnectionExt as _, ImageFormat, InputFocus, MapState, Window,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

/// Size of the display, pixels.
const SIZE: (u16, u16) = (1280, 800);

/// Longest wait for something that must happen: a bound for a test that hangs, not a speed.
const PATIENCE: Duration = Duration::from_mins(5);

/// Hills seen from 20 km straight above.
const PROJECT: &str = r##"{"version": 1,
    "camera": {"lon_deg": 10.0, "lat_deg": 45.0, "altitude_m": 20000.0},
    "layers": [
        {"id": "hills", "name": "Hills", "kind": "noise", "amplitude_m": 500.0, "wavelength_m": 9000.0, "octaves": 5},
        {"id": "tint", "name": "Tint", "kind": "tint", "stops": [
            {"height_m": -500.0, "colour": "#305028"}, {"height_m": 500.0, "colour": "#d8d0b0"}]}]}"##;

const CONTROL: u32 = 0xffe3;
const RETURN: u32 = 0xff0d;

/// A program that ends with the test.
struct Program(Child);

impl Drop for Program {
    fn drop(&mut self) {
        // It may have ended by itself.
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

/// A display in memory with the studio's window on it.
struct Desk {
    studio: Program,
    connection: RustConnection,
    root: Window,
    window: Window,
    _server: Program,
}

impl Desk {
    fn open(project: &Path, state: &Path) -> Self {
        let mut server = Command::new("Xvfb");
        let screen = format!("{}x{}x24", SIZE.0, SIZE.1);
        server.args([
            "-displayfd",
            "1",
            "-nolisten",
            "tcp",
            "-screen",
            "0",
            &screen,
        ]);
        let mut server = server
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb, which `cargo xtask test` installs");
        let mut number = String::new();
        let output = server.stdout.take().unwrap();
        let server = Program(server);
        BufReader::new(output).read_line(&mut number).unwrap();
        let display = format!(":{}", number.trim());

        let mut studio = Command::new(env!("CARGO_BIN_EXE_relievo"));
        studio
            .arg(project)
            .env("DISPLAY", &display)
            .env_remove("WAYLAND_DISPLAY");
        for variable in ["XDG_RUNTIME_DIR", "XDG_STATE_HOME", "XDG_CACHE_HOME"] {
            studio.env(variable, state);
        }
        let studio = Program(studio.spawn().unwrap());

        let (connection, screen) = x11rb::connect(Some(&display)).unwrap();
        let root = connection.setup().roots[screen].root;
        let window = until("the window", || visible_child(&connection, root));
        let whole = ConfigureWindowAux::new()
            .x(0)
            .y(0)
            .width(u32::from(SIZE.0))
            .height(u32::from(SIZE.1));
        connection.configure_window(window, &whole).unwrap();
        let desk = Self {
            studio,
            connection,
            root,
            window,
            _server: server,
        };
        desk.focus();
        desk
    }

    /// Nobody else gives a window the keys: there is no window manager.
    fn focus(&self) {
        let focus = InputFocus::PARENT;
        self.connection
            .set_input_focus(focus, self.window, x11rb::CURRENT_TIME)
            .unwrap()
            .check()
            .unwrap();
    }

    /// Red, green and blue of the pixels of a rectangle around a point of the display.
    fn pixels(&self, (x, y): (i16, i16), (width, height): (u16, u16)) -> Vec<[u8; 3]> {
        let (x, y) = (x - width as i16 / 2, y - height as i16 / 2);
        let format = ImageFormat::Z_PIXMAP;
        let image = self
            .connection
            .get_image(format, self.root, x, y, width, height, u32::MAX);
        let data = image.unwrap().reply().unwrap().data;
        data.chunks_exact(4).map(|p| [p[2], p[1], p[0]]).collect()
    }

    fn event(&self, kind: u8, detail: u8, (x, y): (i16, i16)) {
        self.connection
            .xtest_fake_input(kind, detail, x11rb::CURRENT_TIME, self.root, x, y, 0)
            .unwrap()
            .check()
            .unwrap();
        // A person is slower than a frame, and two clicks in one frame are one.
        std::thread::sleep(Duration::from_millis(60));
    }

    fn click(&self, at: (i16, i16)) {
        self.event(xproto::MOTION_NOTIFY_EVENT, 0, at);
        self.event(xproto::BUTTON_PRESS_EVENT, 1, at);
        self.event(xproto::BUTTON_RELEASE_EVENT, 1, at);
    }

    fn press(&self, keysyms: &[u32]) {
        let codes: Vec<u8> = keysyms.iter().map(|k| self.keycode(*k)).collect();
        for code in &codes {
            self.event(xproto::KEY_PRESS_EVENT, *code, (0, 0));
        }
        for code in codes.iter().rev() {
            self.event(xproto::KEY_RELEASE_EVENT, *code, (0, 0));
        }
    }

    fn keycode(&self, keysym: u32) -> u8 {
        let setup = self.connection.setup();
        let (least, most) = (setup.min_keycode, setup.max_keycode);
        let mapping = self
            .connection
            .get_keyboard_mapping(least, most - least + 1);
        let mapping = mapping.unwrap().reply().unwrap();
        let width = usize::from(mapping.keysyms_per_keycode);
        let at = mapping.keysyms.iter().position(|k| *k == keysym).unwrap();
        least + u8::try_from(at / width).unwrap()
    }
}

/// A child of the root that is shown and large: the program's window, not a helper of its.
fn visible_child(connection: &RustConnection, root: Window) -> Option<Window> {
    let children = connection
        .query_tree(root)
        .unwrap()
        .reply()
        .unwrap()
        .children;
    children.into_iter().find(|child| {
        let attributes = connection.get_window_attributes(*child).unwrap().reply();
        let geometry = connection.get_geometry(*child).unwrap().reply();
        attributes.is_ok_and(|a| a.map_state == MapState::VIEWABLE)
            && geometry.is_ok_and(|g| g.width > 300 && g.height > 200)
    })
}

/// Asks again and again until there is an answer.
fn until<T>(what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(start.elapsed() < PATIENCE, "never came: {what}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn file(folder: &Path) -> PathBuf {
    folder.join("plan.relievo")
}

#[test]
fn a_polygon_is_drawn_and_saved_in_the_real_window() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(file(folder.path()), PROJECT).unwrap();
    let mut desk = Desk::open(&file(folder.path()), folder.path());

    let middle = (SIZE.0 as i16 / 2, SIZE.1 as i16 / 2);
    until("a picture of the ground", || {
        let colours: HashSet<[u8; 3]> = desk.pixels(middle, (300, 200)).into_iter().collect();
        (colours.len() > 200).then_some(())
    });
    desk.focus();
    // The bar above the view tells what the tool does: once nothing else changes there, it is the tool.
    let bar = || desk.pixels((middle.0, 60), (600, 70));
    let (mut before, mut same) = (bar(), 0);
    until("a picture at rest", || {
        let now = bar();
        same = if now == before { same + 1 } else { 0 };
        before = now;
        (same > 20).then_some(())
    });
    desk.press(&[u32::from(b'p')]);
    until("the tool", || (bar() != before).then_some(()));
    for (x, y) in [(-120, 80), (120, 80), (0, -90)] {
        let at = (middle.0 + x, middle.1 + y);
        desk.click(at);
        // What shows where a vertex would be goes with the pointer.
        desk.event(xproto::MOTION_NOTIFY_EVENT, 0, (at.0 + 60, at.1 + 25));
        until("the vertex", || {
            let is_yellow = |[r, g, b]: &[u8; 3]| *r > 230 && *g > 180 && *b < 130;
            desk.pixels(at, (13, 13))
                .iter()
                .any(is_yellow)
                .then_some(())
        });
        // Two clicks soon after each other would be a double click.
        std::thread::sleep(Duration::from_millis(600));
    }
    desk.press(&[RETURN]);
    desk.press(&[CONTROL, u32::from(b's')]);
    let saved = until("the saved file", || {
        let text = std::fs::read_to_string(file(folder.path())).unwrap();
        text.contains("\"elements\"").then_some(text)
    });
    assert_eq!(saved.matches("\"kind\": \"polygon\"").count(), 1, "{saved}");
    assert!(saved.contains("\"platform\""), "{saved}");

    desk.press(&[CONTROL, u32::from(b'q')]);
    let status = until("the end of the program", || {
        desk.studio.0.try_wait().unwrap()
    });
    assert!(status.success(), "{status}");
}
