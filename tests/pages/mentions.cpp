// What a page mentions in passing: paths and links exist, programs have the options that are named.
#include "tests/pages/child.h"
#include "tests/pages/play.h"

#include <algorithm>
#include <array>
#include <map>
#include <sstream>

namespace zoned::pages {

namespace fs = std::filesystem;

namespace {

constexpr std::array<std::string_view, 15> kExtensions = {".h",
                                                          ".cpp",
                                                          ".md",
                                                          ".txtpb",
                                                          ".proto",
                                                          ".sh",
                                                          ".txt",
                                                          ".png",
                                                          ".obj",
                                                          ".policy",
                                                          ".cl",
                                                          ".cmake",
                                                          ".yaml",
                                                          ".service",
                                                          ".in"};

bool ends_with(const std::string& text, std::string_view end) {
    return text.size() >= end.size() &&
           text.compare(text.size() - end.size(), end.size(), end) == 0;
}

/// The file itself, or a name without its extension that stands for a header and its source.
bool exists_as_said(const fs::path& path) {
    return fs::exists(path) || fs::exists(path.string() + ".h") ||
           fs::exists(path.string() + ".cpp") || fs::exists(path.string() + ".proto");
}

class Checker {
  public:
    Checker(const Page& page, const Stage& stage)
        : stage_(stage),
          folder_(stage.root / fs::path(page.path).parent_path()) {
        for (const Step& step : page.steps) {
            if (step.kind == Step::Kind::kFile) {
                written_.push_back(fs::path(step.argument).filename());
            }
        }
        for (const Mention& mention : page.mentions) {
            if (mention.link) {
                check_link(mention);
            } else if (mention.text.find(' ') == std::string::npos) {
                check_path(mention);
            } else {
                check_command(mention);
            }
        }
    }

    std::vector<Finding> wrong_;

  private:
    void check_link(const Mention& mention) {
        if (mention.text.rfind("http", 0) == 0 || mention.text.rfind('#', 0) == 0) {
            return;
        }
        const std::string target = mention.text.substr(0, mention.text.find('#'));
        if (!fs::exists(folder_ / target)) {
            wrong_.push_back({mention.line, "the link leads nowhere: " + mention.text});
        }
    }

    void check_path(const Mention& mention) {
        const std::string& text = mention.text;
        const bool plain =
            text.find_first_not_of(
                "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.-/") ==
            std::string::npos;
        const std::size_t slash = text.find('/');
        const bool file =
            std::any_of(kExtensions.begin(), kExtensions.end(), [&](std::string_view e) {
                return text.size() > e.size() && ends_with(text, e);
            });
        if (!plain || slash == 0 || slash == std::string::npos || text.rfind("..", 0) == 0 ||
            text.rfind("build", 0) == 0) {
            return;
        }
        const std::string first = text.substr(0, slash);
        if (!file && !fs::is_directory(stage_.root / first) && !fs::is_directory(folder_ / first)) {
            return;
        }
        if (std::find(written_.begin(), written_.end(), fs::path(text).filename()) !=
            written_.end()) {
            return;
        }
        if (!exists_as_said(stage_.root / text) && !exists_as_said(folder_ / text)) {
            wrong_.push_back({mention.line, "no such file or folder: " + text});
        }
    }

    void check_command(const Mention& mention) {
        std::istringstream in(mention.text);
        std::string program;
        in >> program;
        if (program.rfind("build/", 0) == 0) {
            program = program.substr(6);
        }
        const bool script = program == "server/run.sh" || program == "tests/run.sh" ||
                            program == "config/prepare.sh";
        if (!script && program.rfind("zoned", 0) != 0 && program != "client-sim") {
            return;
        }
        std::string command = script ? program : "build/" + program;
        std::string word;
        for (bool first = true; in >> word; first = false) {
            if (first && program == "zoned" &&
                word.find_first_not_of("abcdefghijklmnopqrstuvwxyz") == std::string::npos) {
                if (help_of("build/zoned").find("\n  " + word + " ") == std::string::npos) {
                    wrong_.push_back({mention.line, "zoned has no command '" + word + "'"});
                    return;
                }
                command += " " + word;
            } else if (word.rfind("--", 0) == 0) {
                const std::string option = word.substr(0, word.find('='));
                if (help_of(command).find(option) == std::string::npos) {
                    wrong_.push_back({mention.line, command + " has no option " + option});
                }
            }
        }
    }

    const std::string& help_of(const std::string& command) {
        const auto [it, added] = helps_.try_emplace(command);
        if (added) {
            ShellChild child(command + " --help", stage_.root, stage_.scratch / "help");
            it->second = child.wait(20.0).printed;
        }
        return it->second;
    }

    const Stage& stage_;
    fs::path folder_;
    std::vector<fs::path> written_;
    std::map<std::string, std::string> helps_;
};

}  // namespace

std::vector<Finding> wrong_mentions(const Page& page, const Stage& stage) {
    return Checker(page, stage).wrong_;
}

}  // namespace zoned::pages
