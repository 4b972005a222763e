#include "tests/bench/compare/program_run.h"

#include "tests/bench/report/results_reader.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

extern char** environ;

namespace zoned::bench {

namespace {

/// A folder that goes with its files.
class ScratchFolder {
  public:
    ScratchFolder() {
        std::string name = (std::filesystem::temp_directory_path() / "zoned-bench-XXXXXX").string();
        if (mkdtemp(name.data()) == nullptr) {
            throw std::runtime_error("can't make a folder like " + name);
        }
        path_ = name;
    }

    ~ScratchFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }

    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    [[nodiscard]] std::string file(const char* name) const { return path_ + "/" + name; }

  private:
    std::string path_;
};

std::string last_line(const std::string& path) {
    std::ifstream in(path);
    std::string last;
    for (std::string line; std::getline(in, line);) {
        last = line.empty() ? last : line;
    }
    return last;
}

/// The exit code, or 128 and the signal that ended it.
int exit_code_of(std::vector<std::string> line, const std::string& errors) {
    std::vector<char*> pointers;
    for (std::string& word : line) {
        pointers.push_back(word.data());
    }
    pointers.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(
        &actions, STDERR_FILENO, errors.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    pid_t child = 0;
    const int failed =
        posix_spawn(&child, pointers[0], &actions, nullptr, pointers.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed != 0) {
        throw std::runtime_error("can't start " + line[0]);
    }
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

Results results_of_program(const std::string& program, const std::vector<std::string>& arguments) {
    const ScratchFolder folder;
    std::vector<std::string> line{program};
    line.insert(line.end(), arguments.begin(), arguments.end());
    line.insert(line.end(), {"--json", folder.file("rows.json")});
    const int code = exit_code_of(line, folder.file("errors"));
    if (code != 0) {
        throw std::runtime_error(program + " ended with " + std::to_string(code) + ": " +
                                 last_line(folder.file("errors")));
    }
    return results_from_json(read_text_file(folder.file("rows.json")), program);
}

bool is_json_file(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    char first = ' ';
    return in >> first && first == '{';
}

}  // namespace zoned::bench
