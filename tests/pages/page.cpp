#include "tests/pages/page.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <sstream>

namespace zoned::pages {

namespace {

constexpr std::string_view kOpen = "<!-- page: ";
constexpr std::string_view kClose = " -->";

std::string trimmed(std::string_view text) {
    while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front())) != 0) {
        text.remove_prefix(1);
    }
    while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0) {
        text.remove_suffix(1);
    }
    return std::string(text);
}

std::vector<std::string> words_of(const std::string& text) {
    std::istringstream in(text);
    std::vector<std::string> words;
    for (std::string word; in >> word;) {
        words.push_back(word);
    }
    return words;
}

/// Languages of blocks that a test of their own reads: proto/WIRE.md by tests/unit/wire.
bool checked_elsewhere(const std::string& language) {
    return language == "wire";
}

class Reader {
  public:
    Reader(const std::string& path, std::string_view text) {
        page_.path = path;
        std::istringstream in{std::string(text)};
        for (std::string line; std::getline(in, line);) {
            ++line_;
            take(line);
        }
        if (in_block_) {
            defect("the block is never closed");
        } else if (marked_) {
            defect("no block follows the comment above");
        }
    }

    Page page_;

  private:
    void defect(const std::string& text) { page_.defects.push_back({line_, text}); }

    void take(const std::string& line) {
        const std::string bare = trimmed(line);
        const bool fence = bare.rfind("```", 0) == 0;
        if (in_block_) {
            if (fence) {
                in_block_ = false;
                close_block();
            } else {
                block_ += line.substr(std::min(indent_, line.find_first_not_of(' '))) + "\n";
            }
        } else if (fence) {
            open_block(line, bare.substr(3));
        } else if (bare.rfind(kOpen, 0) == 0) {
            take_comment(bare);
        } else if (!bare.empty()) {
            if (marked_) {
                defect("a block has to follow the comment above at once");
                forget_marks();
            }
            take_mentions(line);
        }
    }

    void take_comment(const std::string& bare) {
        if (bare.size() < kOpen.size() + kClose.size() ||
            bare.compare(bare.size() - kClose.size(), kClose.size(), kClose) != 0) {
            defect("the comment has to end with -->");
            return;
        }
        const std::string inside =
            trimmed(bare.substr(kOpen.size(), bare.size() - kOpen.size() - kClose.size()));
        const std::size_t space = inside.find(' ');
        const std::string name = inside.substr(0, space);
        const std::string rest =
            space == std::string::npos ? std::string() : trimmed(inside.substr(space));
        if (name == "stop" || name == "sh") {
            Step step;
            step.kind = name == "stop" ? Step::Kind::kStop : Step::Kind::kRun;
            step.line = line_;
            step.text = rest;
            step.hidden = true;
            step.seconds = 120.0;
            page_.steps.push_back(step);
        } else if (name == "ports") {
            page_.ports = words_of(rest);
        } else {
            mark(name, rest);
        }
    }

    void mark(const std::string& name, const std::string& rest) {
        marked_ = true;
        if (rest.empty() && name != "output") {
            defect("'" + name + "' says nothing more");
        }
        if (name == "file" || name == "extends" || name == "output" || name == "skip") {
            said_kind_ = true;
            next_.kind = name == "file"      ? Step::Kind::kFile
                         : name == "extends" ? Step::Kind::kExtends
                         : name == "output"  ? Step::Kind::kOutput
                                             : Step::Kind::kSkip;
            next_.argument = rest;
            next_.any_number = name == "output" && rest == "numbers";
            if (name == "output" && !rest.empty() && rest != "numbers") {
                defect("'output' may be followed by 'numbers' alone");
            }
        } else if (name == "exit") {
            next_.exit_code = std::atoi(rest.c_str());
        } else if (name == "seconds") {
            next_.seconds = std::atof(rest.c_str());
        } else if (name == "background") {
            next_.background = rest;
        } else if (name == "env") {
            next_.environment = rest;
        } else if (name == "append") {
            next_.append = rest;
        } else {
            defect("no comment is called '" + name + "'");
        }
    }

    void open_block(const std::string& line, const std::string& language) {
        in_block_ = true;
        indent_ = line.find('`');
        language_ = words_of(language).empty() ? std::string() : words_of(language).front();
        block_.clear();
        next_.line = line_;
    }

    void close_block() {
        Step step = next_;
        step.text = block_;
        const bool said = said_kind_;
        const bool marked = marked_;
        forget_marks();
        if (language_.empty()) {
            defect("the block above has no language");
        } else if (said) {
            page_.steps.push_back(step);
        } else if (language_ == "sh") {
            if (!step.append.empty() && words_of(step.text).empty()) {
                defect("nothing to append to");
            }
            page_.steps.push_back(step);
        } else if (marked) {
            defect("the comments above are for blocks that are run");
        } else if (language_ != "text" && !checked_elsewhere(language_)) {
            defect("nothing says what becomes of the block above: file, extends, output or skip?");
        }
    }

    void forget_marks() {
        next_ = Step{};
        marked_ = false;
        said_kind_ = false;
    }

    void take_mentions(const std::string& line) {
        for (std::size_t at = line.find('`'); at != std::string::npos;) {
            const std::size_t end = line.find('`', at + 1);
            if (end == std::string::npos) {
                break;
            }
            page_.mentions.push_back({line_, line.substr(at + 1, end - at - 1), false});
            at = line.find('`', end + 1);
        }
        for (std::size_t at = line.find("]("); at != std::string::npos;
             at = line.find("](", at + 2)) {
            const std::size_t end = line.find(')', at);
            if (end != std::string::npos) {
                page_.mentions.push_back({line_, line.substr(at + 2, end - at - 2), true});
            }
        }
    }

    int line_ = 0;
    bool in_block_ = false;
    std::size_t indent_ = 0;
    std::string language_;
    std::string block_;
    Step next_;
    bool marked_ = false;
    bool said_kind_ = false;
};

bool is_digit(char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

/// The end of the number that begins at `at`: digits, a point between them, an exponent.
std::size_t end_of_number(const std::string& line, std::size_t at) {
    const auto digit_at = [&](std::size_t i) {
        return i < line.size() && is_digit(line[i]);
    };
    while (digit_at(at) || (at < line.size() && line[at] == '.' && digit_at(at + 1))) {
        ++at;
    }
    if (at < line.size() && line[at] == 'e') {
        const std::size_t sign =
            at + 1 < line.size() && (line[at + 1] == '-' || line[at + 1] == '+') ? 1U : 0U;
        if (digit_at(at + 1 + sign)) {
            return end_of_number(line, at + 1 + sign);
        }
    }
    return at;
}

/// White space becomes single spaces; with `any_number` every number becomes '#'.
std::string reduced(const std::string& line, bool any_number) {
    std::string out;
    for (std::size_t i = 0; i < line.size();) {
        if (std::isspace(static_cast<unsigned char>(line[i])) != 0) {
            if (!out.empty() && out.back() != ' ') {
                out += ' ';
            }
            ++i;
        } else if (any_number && is_digit(line[i])) {
            i = end_of_number(line, i);
            out += '#';
        } else {
            out += line[i++];
        }
    }
    return trimmed(out);
}

/// `pattern` with "..." for anything, against a whole line.
bool matches(const std::string& line, const std::string& pattern) {
    std::size_t at = 0;
    std::size_t from = 0;
    bool first = true;
    while (true) {
        const std::size_t dots = pattern.find("...", from);
        const std::string piece = pattern.substr(from, dots - from);
        const bool last = dots == std::string::npos;
        if (first ? line.rfind(piece, 0) != 0 : line.find(piece, at) == std::string::npos) {
            return false;
        }
        if (last) {
            return first ? line == piece
                         : line.size() >= at + piece.size() &&
                               line.compare(line.size() - piece.size(), piece.size(), piece) == 0;
        }
        at = (first ? 0 : line.find(piece, at)) + piece.size();
        from = dots + 3;
        first = false;
    }
}

}  // namespace

Page read_page(const std::string& path, std::string_view text) {
    return Reader(path, text).page_;
}

namespace {

/// A verdict with a warning of a loaded machine is the same verdict.
std::string without_warning(const std::string& line) {
    return line.substr(0, line.find(", with a warning: "));
}

}  // namespace

bool has_lines(const std::string& printed,
               const std::string& expected,
               bool any_number,
               std::string& missing) {
    std::istringstream have(printed);
    std::istringstream want(expected);
    std::string line;
    for (std::string wanted; std::getline(want, wanted);) {
        const std::string pattern = reduced(wanted, any_number);
        if (pattern.empty() || pattern == "...") {
            continue;
        }
        bool found = false;
        while (!found && std::getline(have, line)) {
            found = matches(reduced(without_warning(line), any_number), pattern);
        }
        if (!found) {
            missing = wanted;
            return false;
        }
    }
    return true;
}

}  // namespace zoned::pages
