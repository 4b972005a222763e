#include "server/config/text/brace_check.h"

#include "server/config/text/text_repair.h"

#include <algorithm>
#include <cctype>
#include <utility>
#include <vector>

namespace zoned::config {

namespace {

struct OpenBlock {
    char bracket = '{';
    std::size_t offset = 0;
    std::size_t indentation = 0;  ///< of its line
    bool leads = false;           ///< it ends its line: what follows is expected to stand deeper
    bool seen = false;            ///< the line after its beginning was looked at
};

char closing_of(char bracket) {
    return bracket == '{' ? '}' : ']';
}

/// "'zone {' of line 12"; the name is what stands before the bracket.
std::string block_name(const std::string& text, const OpenBlock& block) {
    std::size_t end = block.offset;
    while (end > 0 && (text[end - 1] == ' ' || text[end - 1] == ':')) {
        --end;
    }
    std::size_t begin = end;
    while (begin > 0 && (std::isalnum(static_cast<unsigned char>(text[begin - 1])) != 0 ||
                         text[begin - 1] == '_')) {
        --begin;
    }
    const std::string name = text.substr(begin, end - begin);
    int line = 0;
    int column = 0;
    place_of(text, block.offset, line, column);
    return "'" + name + (name.empty() ? "" : " ") + block.bracket + "' of line " +
           std::to_string(line);
}

class BraceScan {
  public:
    explicit BraceScan(const std::string& text) : text_(text) {}

    std::optional<BraceMistake> run() {
        for (std::size_t i = 0; i < text_.size() && !found_; ++i) {
            const char c = text_[i];
            if (c == '\n') {
                begin_line(i + 1);
            } else if (c == '#') {
                i = std::min(text_.find('\n', i), text_.size()) - 1;
            } else if (c == '"' || c == '\'') {
                i = end_of_string(i);
            } else if (c == '{' || c == '[') {
                open(i);
            } else if (c == '}' || c == ']') {
                close(i);
            }
            at_start_ = at_start_ && (c == ' ' || c == '\t' || c == '\r' || c == '\n');
        }
        if (!found_ && !open_.empty()) {
            // Braces alone: the outermost that is open when the text ends.
            report(clue_ ? *clue_ : open_.front(), "");
        }
        return found_;
    }

  private:
    void begin_line(std::size_t at) {
        indentation_ = 0;
        while (at + indentation_ < text_.size() &&
               (text_[at + indentation_] == ' ' || text_[at + indentation_] == '\t')) {
            ++indentation_;
        }
        at_start_ = true;
        const std::size_t first = at + indentation_;
        if (first >= text_.size() || text_[first] == '\n' || open_.empty() || open_.back().leads) {
            return;
        }
        // A block that holds something in its first line goes on deeper, or ends in that line.
        OpenBlock& block = open_.back();
        if (!clue_ && !block.seen && indentation_ <= block.indentation && text_[first] != '}' &&
            text_[first] != ']') {
            clue_ = block;
        }
        block.seen = true;
    }

    /// The last character of the string that begins here, or of its line.
    [[nodiscard]] std::size_t end_of_string(std::size_t at) const {
        for (std::size_t i = at + 1; i < text_.size() && text_[i] != '\n'; ++i) {
            if (text_[i] == '\\') {
                ++i;
            } else if (text_[i] == text_[at]) {
                return i;
            }
        }
        return std::min(text_.find('\n', at), text_.size()) - 1;
    }

    void open(std::size_t at) {
        const std::size_t end = text_.find_first_not_of(" \t\r", at + 1);
        const bool leads = end == std::string::npos || text_[end] == '\n' || text_[end] == '#';
        // A block that begins no deeper than the one around it: that one should have ended.
        if (!clue_ && !open_.empty() && open_.back().leads && leads &&
            indentation_ <= open_.back().indentation &&
            line_of(at) != line_of(open_.back().offset)) {
            clue_ = open_.back();
        }
        open_.push_back({text_[at], at, indentation_, leads, false});
    }

    void close(std::size_t at) {
        if (open_.empty()) {
            found_ = place(at);
            found_->text = "this ";
            found_->text += text_[at];
            found_->text += " closes nothing: take it out, or look for the beginning of its block";
            return;
        }
        const OpenBlock block = open_.back();
        if (closing_of(block.bracket) != text_[at]) {
            std::string where = " before the ";
            where += text_[at];
            where += " of line ";
            where += std::to_string(line_of(at));
            report(block, where);
            return;
        }
        const bool under_outer =
            std::any_of(open_.begin(), open_.end() - 1, [&](const OpenBlock& outer) {
                return outer.leads && outer.indentation == indentation_;
            });
        if (!clue_ && at_start_ && block.leads && block.indentation != indentation_ &&
            under_outer) {
            clue_ = block;
        }
        open_.pop_back();
    }

    [[nodiscard]] int line_of(std::size_t at) const { return place(at).line; }

    [[nodiscard]] BraceMistake place(std::size_t at) const {
        BraceMistake out;
        place_of(text_, at, out.line, out.column);
        return out;
    }

    void report(const OpenBlock& block, const std::string& where) {
        found_ = place(block.offset);
        found_->text = "the block " + block_name(text_, block) + " has no end" + where + ": a " +
                       closing_of(block.bracket) + " is missing";
    }

    const std::string& text_;
    std::vector<OpenBlock> open_;
    std::size_t indentation_ = 0;
    bool at_start_ = true;           ///< nothing but space so far in this line
    std::optional<OpenBlock> clue_;  ///< the block that lacks its end, by the indentation
    std::optional<BraceMistake> found_;
};

}  // namespace

std::optional<BraceMistake> find_brace_mistake(const std::string& text) {
    return BraceScan(text).run();
}

}  // namespace zoned::config
