#include "tests/lint/pages.h"

#include "tests/lint/text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <string>

namespace zoned::lint {

namespace {

std::string_view trimmed(std::string_view s) {
    const std::size_t begin = s.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) {
        return {};
    }
    return s.substr(begin, s.find_last_not_of(" \t\r") - begin + 1);
}

/// The length of the mark that a list item begins with ("- ", "12. "); 0: it is none.
std::size_t list_mark(std::string_view line) {
    if (line.starts_with("- ") || line.starts_with("* ") || line.starts_with("+ ")) {
        return 2;
    }
    const std::size_t digits = std::min(line.find_first_not_of("0123456789"), line.size());
    return digits > 0 && line.substr(digits, 2) == ". " ? digits + 2 : 0;
}

bool is_word(std::string_view text) {
    return std::any_of(text.begin(), text.end(), [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0;
    });
}

/// Whether a word ends its sentence: a mark at its end, behind which only quotes, brackets and
/// emphasis may stand; "e.g." and the like do not.
bool ends_sentence(std::string_view word) {
    static constexpr std::array<std::string_view, 4> kAbbreviations{"e.g.", "i.e.", "cf.", "vs."};
    const std::size_t last = word.find_last_not_of(")]*_\"'`");
    if (last == std::string_view::npos) {
        return false;
    }
    word = word.substr(0, last + 1);
    const std::size_t first = std::min(word.find_first_not_of("([*_\"'`"), word.size());
    return (word.back() == '.' || word.back() == '?' || word.back() == '!') &&
           std::find(kAbbreviations.begin(), kAbbreviations.end(), word.substr(first)) ==
               kAbbreviations.end();
}

/// Goes over a page line by line.
class SentenceReader {
  public:
    std::vector<Sentence> read(std::string_view text) {
        for (const std::string_view line : lines_of(text)) {
            ++line_;
            take(trimmed(line));
        }
        end();
        return std::move(found_);
    }

  private:
    void take(std::string_view line) {
        if (line.starts_with("```")) {
            code_ = !code_;
            end();
        } else if (comment_ || line.starts_with("<!--")) {
            comment_ = line.find("-->") == std::string_view::npos;
            end();
        } else if (line.empty() || line.starts_with('#') || line.starts_with('|')) {
            end();
        } else if (!code_) {
            if (const std::size_t mark = list_mark(line); mark > 0) {
                end();
                line.remove_prefix(mark);
            }
            add(line);
        }
    }

    void add(std::string_view line) {
        while (!line.empty()) {
            const std::size_t size = std::min(line.find_first_of(" \t"), line.size());
            const std::string_view word = line.substr(0, size);
            line.remove_prefix(std::min(size + 1, line.size()));
            if (is_word(word)) {
                open_.line = open_.words == 0 ? line_ : open_.line;
                ++open_.words;
            }
            if (ends_sentence(word)) {
                end();
            }
        }
    }

    void end() {
        if (open_.words > 0) {
            found_.push_back(open_);
        }
        open_ = {};
    }

    int line_ = 0;
    bool code_ = false;
    bool comment_ = false;
    Sentence open_;
    std::vector<Sentence> found_;
};

void check_cells(const SourceFile& file, std::vector<Finding>& findings) {
    int number = 0;
    bool code = false;
    for (std::string_view line : lines_of(file.text)) {
        ++number;
        line = trimmed(line);
        code = line.starts_with("```") ? !code : code;
        if (code || !line.starts_with('|')) {
            continue;
        }
        while (!line.empty()) {
            std::size_t end = line.find('|');
            while (end != std::string_view::npos && end > 0 && line[end - 1] == '\\') {
                end = line.find('|', end + 1);
            }
            const std::size_t length = trimmed(line.substr(0, end)).size();
            if (length > kMostInCell) {
                findings.push_back({file.path,
                                    number,
                                    "a cell of " + std::to_string(length) + " characters, " +
                                        std::to_string(kMostInCell) + " are allowed"});
            }
            line.remove_prefix(end == std::string_view::npos ? line.size() : end + 1);
        }
    }
}

}  // namespace

std::vector<Sentence> sentences_of(std::string_view text) {
    return SentenceReader().read(text);
}

std::vector<Finding> check_page(const SourceFile& file) {
    std::vector<Finding> findings;
    if (!file.path.ends_with(".md")) {
        return findings;
    }
    const std::vector<Sentence> sentences = sentences_of(file.text);
    int words = 0;
    for (const Sentence& sentence : sentences) {
        words += sentence.words;
        if (sentence.words > kMostWords) {
            findings.push_back({file.path,
                                sentence.line,
                                "a sentence of " + std::to_string(sentence.words) + " words, " +
                                    std::to_string(kMostWords) + " are allowed"});
        }
    }
    const double mean = sentences.empty()
                            ? 0.0
                            : static_cast<double>(words) / static_cast<double>(sentences.size());
    if (mean > kMostMeanWords) {
        std::array<char, 80> text{};
        std::snprintf(text.data(),
                      text.size(),
                      "sentences of %.1f words in the mean, %.0f are allowed",
                      mean,
                      kMostMeanWords);
        findings.push_back({file.path, 0, text.data()});
    }
    check_cells(file, findings);
    return findings;
}

}  // namespace zoned::lint
