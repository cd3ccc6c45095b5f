# Sourced by scripts that compare this checkout with a commit.

# Both measure for themselves in every run.
export HFVDB_CACHE=

# program_of COMMIT: builds the program as it is at a commit, unless that was done before, and prints its path.
program_of() {
    local commit tree=$PWD/target/guard/tree program
    mkdir -p target/guard
    commit=$(git rev-parse --verify --quiet "$1^{commit}") || { echo "there is no commit $1" >&2; return 2; }
    program=$PWD/target/guard/$commit
    if [ ! -x "$program" ]; then
        git worktree remove --force "$tree" 2>/dev/null || true
        git worktree add --quiet --detach "$tree" "$commit"
        cargo build --release --locked --quiet --bin hfvdb --manifest-path "$tree/Cargo.toml" \
            --target-dir target/guard/build || { git worktree remove --force "$tree"; return 2; }
        git worktree remove --force "$tree"
        cp target/guard/build/release/hfvdb "$program"
    fi
    echo "$program"
}
