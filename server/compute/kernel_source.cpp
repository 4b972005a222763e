#include "server/compute/kernel_source.h"

#include <algorithm>
#include <charconv>
#include <set>
#include <sstream>

namespace zoned::compute {

namespace {

/// The target of a line `#include "..."`, or nothing.
std::optional<std::string_view> quoted_include(std::string_view line) {
    constexpr std::string_view kInclude = "#include \"";
    if (line.substr(0, kInclude.size()) != kInclude) {
        return std::nullopt;
    }
    line.remove_prefix(kInclude.size());
    const std::size_t end = line.find('"');
    return end == std::string_view::npos ? std::nullopt : std::optional(line.substr(0, end));
}

class Expansion {
  public:
    explicit Expansion(const FindKernelFile& find) : find_(find) {}

    /// False: error_ says why.
    bool add(std::string_view path, const std::string& included_at) {
        const std::optional<std::string_view> text = find_(path);
        if (!text) {
            error_ = included_at + "there is no kernel file \"" + std::string(path) + "\"";
            return false;
        }
        seen_.emplace(path);
        const std::string name(path);
        out_ += "#line 1 \"" + name + "\"\n";
        int number = 0;
        std::string_view rest = *text;
        while (!rest.empty()) {
            const std::size_t end = std::min(rest.find('\n'), rest.size());
            const std::string_view line = rest.substr(0, end);
            rest.remove_prefix(std::min(end + 1, rest.size()));
            ++number;
            if (!add_line(line, name, number)) {
                return false;
            }
        }
        return true;
    }

    [[nodiscard]] const std::string& text() const { return out_; }

    [[nodiscard]] const std::string& error() const { return error_; }

  private:
    bool add_line(std::string_view line, const std::string& file, int number) {
        const std::optional<std::string_view> target = quoted_include(line);
        if (target && seen_.find(*target) == seen_.end()) {
            if (!add(*target, file + ":" + std::to_string(number) + ": ")) {
                return false;
            }
            out_ += "#line " + std::to_string(number + 1) + " \"" + file + "\"\n";
        } else if (target || line == "#pragma once") {
            out_ += '\n';
        } else {
            out_ += line;
            out_ += '\n';
        }
        return true;
    }

    const FindKernelFile& find_;
    std::set<std::string, std::less<>> seen_;
    std::string out_;
    std::string error_;
};

/// "kernels/particles.cl:3" of a line of an expanded text; both count from 1.
std::string place_of(std::string_view source, std::size_t line) {
    std::string file = "<kernel>";
    std::size_t place = 0;
    std::istringstream text{std::string(source)};
    std::string content;
    for (std::size_t at = 1; at <= line && std::getline(text, content); ++at) {
        std::istringstream words(content);
        std::string directive;
        std::size_t next = 0;
        if (words >> directive >> next && directive == "#line") {
            const std::size_t quote = content.find('"');
            file = content.substr(quote + 1, content.rfind('"') - quote - 1);
            place = next - 1;
        } else {
            ++place;
        }
    }
    return file + ":" + std::to_string(place);
}

}  // namespace

std::string name_places(std::string_view log, std::string_view source) {
    constexpr std::string_view kWhole = "<kernel>:";
    std::string out;
    for (std::size_t at = log.find(kWhole); at != std::string_view::npos; at = log.find(kWhole)) {
        out += log.substr(0, at);
        log.remove_prefix(at);
        std::size_t line = 0;
        const char* digits = log.data() + kWhole.size();
        const auto end = std::from_chars(digits, log.data() + log.size(), line).ptr;
        out += end == digits ? std::string(kWhole) : place_of(source, line);
        log.remove_prefix(static_cast<std::size_t>(end - log.data()));
    }
    return out.append(log);
}

core::Result<std::string> expand_kernel(std::string_view path, const FindKernelFile& find) {
    Expansion expansion(find);
    if (!expansion.add(path, "")) {
        return core::Result<std::string>::failure(expansion.error());
    }
    return expansion.text();
}

core::Result<std::string> kernel_source(std::string_view path) {
    return expand_kernel(path, [](std::string_view wanted) -> std::optional<std::string_view> {
        for (const KernelFile& file : kernel_files()) {
            if (file.path == wanted) {
                return file.text;
            }
        }
        return std::nullopt;
    });
}

}  // namespace zoned::compute
