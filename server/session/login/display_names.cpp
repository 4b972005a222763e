#include "server/session/login/display_names.h"

#include "shared/core/utf8.h"

namespace zoned::session {

bool is_valid_name(std::string_view name) {
    return !name.empty() && name.size() <= kMaxNameBytes && core::is_clean_utf8(name) &&
           name.find_first_not_of(' ') != std::string_view::npos;
}

bool is_valid_team(std::string_view team) {
    return team.size() <= kMaxNameBytes && core::is_clean_utf8(team);
}

std::string printable(std::string_view text, std::size_t max_bytes) {
    std::string out;
    for (const char c : text.substr(0, max_bytes)) {
        out.push_back(c >= 0x20 && c < 0x7F ? c : '?');
    }
    if (text.size() > max_bytes) {
        out += "...";
    }
    return out;
}

}  // namespace zoned::session
