//! The `sdp3` command.

fn main() -> std::process::ExitCode {
    sdp3::main()
}
