#include "tests/pages/play.h"

#include "tests/pages/child.h"

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cctype>
#include <fstream>
#include <iterator>
#include <memory>
#include <set>
#include <stdexcept>

namespace zoned::pages {

namespace fs = std::filesystem;

namespace {

constexpr double kStopS = 20.0;
constexpr std::size_t kTailBytes = 2500;

std::string read_text(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void write_text(const fs::path& file, const std::string& text) {
    fs::create_directories(file.parent_path());
    std::ofstream out(file, std::ios::binary | std::ios::trunc);
    out << text;
    if (!out.flush()) {
        throw std::runtime_error("cannot write " + file.string());
    }
}

std::string tail(const std::string& text) {
    return text.size() <= kTailBytes ? text : "[...]" + text.substr(text.size() - kTailBytes);
}

/// A port that nobody listens on right now.
std::string free_port() {
    const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    const bool good = ::bind(fd, reinterpret_cast<const sockaddr*>(&address), size) == 0 &&
                      ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) == 0;
    ::close(fd);
    if (!good) {
        throw std::runtime_error("no free port");
    }
    return std::to_string(ntohs(address.sin_port));
}

/// Replaces `from` where no other digit stands beside it.
void replace_number(std::string& text, const std::string& from, const std::string& to) {
    const auto digit = [&](std::size_t at) {
        return at < text.size() && std::isdigit(static_cast<unsigned char>(text[at])) != 0;
    };
    for (std::size_t at = text.find(from); at != std::string::npos;
         at = text.find(from, at + to.size())) {
        if ((at > 0 && digit(at - 1)) || digit(at + from.size())) {
            continue;
        }
        text.replace(at, from.size(), to);
    }
}

std::string without_end(std::string text) {
    while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0) {
        text.pop_back();
    }
    return text;
}

const std::set<std::string> kTopLevel = {"CMakeLists.txt",
                                         "README.md",
                                         "client-sim",
                                         "config",
                                         "docker",
                                         "kernels",
                                         "proto",
                                         "server",
                                         "shared",
                                         "tests"};

void remove_others(const fs::path& folder, const std::set<std::string>& kept) {
    for (const auto& entry : fs::directory_iterator(folder)) {
        if (!kept.contains(entry.path().filename().string())) {
            fs::remove_all(entry.path());
        }
    }
}

bool is_same_file(const fs::path& a, const fs::path& b) {
    const fs::file_status of_a = fs::symlink_status(a);
    const fs::file_status of_b = fs::symlink_status(b);
    return fs::is_regular_file(of_b) && of_a.permissions() == of_b.permissions() &&
           fs::file_size(a) == fs::file_size(b) && fs::last_write_time(a) == fs::last_write_time(b);
}

/// Makes `copy` what `original` is. Most of it is so already: to make all files anew would take
/// longer than most pages do.
void mirror(const fs::path& original, const fs::path& copy) {
    if (!fs::is_directory(original)) {
        if (!is_same_file(original, copy)) {
            fs::remove_all(copy);
            fs::copy_file(original, copy);
            fs::last_write_time(copy, fs::last_write_time(original));
        }
        return;
    }
    if (!fs::is_directory(fs::symlink_status(copy))) {
        fs::remove_all(copy);
        fs::create_directory(copy);
    }
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(original)) {
        names.insert(entry.path().filename().string());
        mirror(entry.path(), copy / entry.path().filename());
    }
    remove_others(copy, names);
}

class Player {
  public:
    Player(const Page& page, const Stage& stage) : stage_(stage), folder_(stage.root) {
        std::vector<Step> steps = page.steps;
        for (const std::string& port : page.ports) {
            const std::string other = free_port();
            for (Step& step : steps) {
                replace_number(step.text, port, other);
                replace_number(step.background, port, other);
                replace_number(step.append, port, other);
            }
        }
        for (const Step& step : steps) {
            take(step);
            if (!played_.failures.empty()) {
                break;  // what follows builds on it
            }
        }
        if (played_.failures.empty()) {
            stop(steps.empty() ? 0 : steps.back().line);
        }
    }

    Played played_;

  private:
    void fail(const Step& step, const std::string& text) {
        played_.failures.push_back({step.line, text});
    }

    void take(const Step& step) {
        switch (step.kind) {
            case Step::Kind::kRun:
                run(step);
                break;
            case Step::Kind::kFile:
                write_text(folder_ / step.argument, step.text);
                break;
            case Step::Kind::kExtends:
                extend(step);
                break;
            case Step::Kind::kOutput:
                compare(step);
                break;
            case Step::Kind::kSkip:
                played_.skipped.push_back({step.line, step.argument});
                break;
            case Step::Kind::kStop:
                stop(step.line);
                break;
        }
    }

    /// The shell says where it stands when it ends: the next one begins there.
    [[nodiscard]] std::string script_of(const Step& step, const fs::path& where) const {
        std::string script = "set -euo pipefail\n";
        if (!step.environment.empty()) {
            script += "export " + step.environment + "\n";
        }
        const std::string command =
            without_end(step.text) + (step.append.empty() ? "" : " " + step.append);
        if (!step.background.empty()) {
            return script + "exec " + command + "\n";
        }
        return script + "trap 'pwd > " + where.string() + "' EXIT\n" + command + "\n";
    }

    void run(const Step& step) {
        const fs::path where = stage_.scratch / "where";
        const fs::path log = stage_.scratch / ("log" + std::to_string(++logs_));
        if (!step.append.empty() || !step.environment.empty()) {
            played_.shortened.push_back(
                {step.line, step.environment + (step.append.empty() ? "" : " ... " + step.append)});
        }
        played_.commands += step.hidden ? 0 : 1;
        auto child = std::make_unique<ShellChild>(script_of(step, where), folder_, log);
        if (!step.background.empty()) {
            const bool ready = child->wait_for(step.background, step.seconds);
            printed_ = child->printed();
            if (!ready) {
                fail(step,
                     "never printed '" + step.background + "':\n" + step.text + tail(printed_));
                return;
            }
            background_.push_back({step.line, step.exit_code, std::move(child)});
            return;
        }
        const ShellResult result = child->wait(step.seconds);
        printed_ = result.printed;
        if (result.late) {
            fail(step,
                 "took more than " + std::to_string(static_cast<int>(step.seconds)) + " s:\n" +
                     step.text + tail(printed_));
        } else if (result.exit_code != step.exit_code) {
            fail(step,
                 "ended with exit code " + std::to_string(result.exit_code) + ", not " +
                     std::to_string(step.exit_code) + ":\n" + step.text + tail(printed_));
        } else {
            folder_ = without_end(read_text(where));
        }
    }

    void extend(const Step& step) {
        const fs::path config = stage_.root / step.argument;
        const fs::path extended = config.parent_path() / "extended_by_a_page.txtpb";
        write_text(extended, read_text(config) + "\n" + step.text);
        Step check;
        check.line = step.line;
        check.hidden = true;
        check.text = (stage_.root / "build/zoned").string() + " check " + extended.string();
        run(check);
        fs::remove(extended);
    }

    void compare(const Step& step) {
        std::string missing;
        if (!has_lines(printed_, step.text, step.any_number, missing)) {
            fail(step, "the commands above did not print\n" + missing + "\nbut\n" + tail(printed_));
        }
    }

    void stop(int line) {
        for (auto& [begun, exit_code, child] : background_) {
            const ShellResult result = child->stop(kStopS);
            printed_ = result.printed;
            if (result.exit_code != exit_code) {
                played_.failures.push_back(
                    {line,
                     "what line " + std::to_string(begun) + " started ended with exit code " +
                         std::to_string(result.exit_code) + ":\n" + tail(printed_)});
            }
        }
        background_.clear();
    }

    const Stage& stage_;
    fs::path folder_;
    std::string printed_;

    struct Background {
        int line = 0;
        int exit_code = 0;  ///< expected at its end
        std::unique_ptr<ShellChild> child;
    };

    std::vector<Background> background_;
    int logs_ = 0;
};

}  // namespace

Stage set_stage(const fs::path& source, const fs::path& build, const fs::path& scratch) {
    const fs::path root = scratch / "zoned";
    fs::create_directories(root);
    remove_others(scratch, {"zoned"});
    remove_others(root, kTopLevel);
    for (const std::string& name : kTopLevel) {
        mirror(source / name, root / name);
    }
    fs::create_directory_symlink(fs::canonical(build), root / "build");
    return {root, scratch};
}

Played play(const Page& page, const Stage& stage) {
    return Player(page, stage).played_;
}

}  // namespace zoned::pages
