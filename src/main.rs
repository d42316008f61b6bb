//! The program. Everything it does is in [`orogen::cli`].

fn main() -> std::process::ExitCode {
    orogen::cli::main()
}
