#include "server/config/text/check_name.h"

#include <algorithm>
#include <cctype>
#include <cstdio>

namespace zoned::config {

std::string text_of(const char* format, double a, double b, double c) {
    char text[300];
    std::snprintf(text, sizeof(text), format, a, b, c);
    return text;
}

bool check_name(const std::string& name,
                const std::string& what,
                const std::string& path,
                Diagnostics& diagnostics) {
    if (name.empty()) {
        diagnostics.add(path + ".name", what + " needs a name");
        return false;
    }
    const bool plain = std::all_of(name.begin(), name.end(), [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' || c == '.';
    });
    if (!plain) {
        diagnostics.add(path + ".name",
                        "a name consists of letters, digits, '_', '-' and '.' only");
    }
    return plain;
}

}  // namespace zoned::config
