#include "client-sim/app/tickets.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace zoned::app {

namespace {

/// Value of a base64 digit (RFC 4648, both alphabets), or -1.
int digit(char c) {
    if (c >= 'A' && c <= 'Z') {
        return c - 'A';
    }
    if (c >= 'a' && c <= 'z') {
        return c - 'a' + 26;
    }
    if (c >= '0' && c <= '9') {
        return c - '0' + 52;
    }
    if (c == '+' || c == '-') {
        return 62;
    }
    return c == '/' || c == '_' ? 63 : -1;
}

bool is_base64_text(const std::string& text) {
    return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
        return digit(c) >= 0 || c == '=' || c == '\n' || c == '\r';
    });
}

std::string decode(const std::string& line) {
    std::string out;
    std::uint32_t bits = 0;
    int have = 0;
    for (const char c : line) {
        if (digit(c) < 0) {
            continue;
        }
        bits = bits << 6 | static_cast<std::uint32_t>(digit(c));
        have += 6;
        if (have >= 8) {
            have -= 8;
            out.push_back(static_cast<char>(bits >> have & 0xFF));
        }
    }
    return out;
}

void read_file(const std::filesystem::path& path, std::vector<std::string>& tickets) {
    std::ifstream in(path, std::ios::binary);
    if (!in) {
        throw std::runtime_error("cannot read ticket file " + path.string());
    }
    const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    if (!is_base64_text(text)) {
        tickets.push_back(text);
        return;
    }
    std::size_t at = 0;
    while (at < text.size()) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        if (std::string ticket = decode(text.substr(at, end - at)); !ticket.empty()) {
            tickets.push_back(std::move(ticket));
        }
        at = end + 1;
    }
}

}  // namespace

std::vector<std::string> read_tickets(const std::vector<std::string>& paths) {
    std::vector<std::string> tickets;
    for (const std::string& name : paths) {
        std::error_code error;
        if (!std::filesystem::is_directory(name, error)) {
            read_file(name, tickets);
            continue;
        }
        std::vector<std::filesystem::path> files;
        for (const auto& entry : std::filesystem::directory_iterator(name)) {
            if (entry.is_regular_file()) {
                files.push_back(entry.path());
            }
        }
        std::sort(files.begin(), files.end());
        for (const auto& file : files) {
            read_file(file, tickets);
        }
    }
    return tickets;
}

}  // namespace zoned::app
