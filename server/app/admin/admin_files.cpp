#include "server/app/admin/admin_files.h"

#include "server/session/login/secrets.h"
#include "shared/core/files/replace_file.h"
#include "shared/core/hex.h"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace zoned::app {

namespace {

constexpr std::size_t kTokenDigits = 64;
constexpr std::size_t kMostCertificateBytes = 1U << 20U;

[[noreturn]] void fail(const std::string& file, const std::string& what) {
    throw std::runtime_error(file + ": " + what);
}

void replace_or_throw(const std::string& path, const std::string& text, unsigned mode) {
    const auto written = core::replace_file(path, text, mode);
    if (!written) {
        throw std::runtime_error(written.error());
    }
}

bool is_token(const std::string& text) {
    return text.size() == kTokenDigits && std::all_of(text.begin(), text.end(), [](char c) {
               return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
           });
}

}  // namespace

std::string new_admin_token() {
    std::array<std::uint8_t, kTokenDigits / 2> bytes{};
    session::random_bytes(bytes);
    return core::to_hex(bytes);
}

std::string read_small_file(const std::string& path, std::size_t most_bytes) {
    std::ifstream in(path, std::ios::binary);
    if (!in) {
        fail(path, std::string("cannot be read: ") + std::strerror(errno));
    }
    std::string text(most_bytes + 1, '\0');
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(in.gcount()));
    if (text.size() > most_bytes) {
        fail(path, "is longer than " + std::to_string(most_bytes) + " bytes");
    }
    return text;
}

std::string admin_token(const std::string& folder) {
    const std::string path = folder + "/admin.token";
    std::error_code ignored;
    std::filesystem::create_directories(folder, ignored);

    struct stat status {};

    if (::stat(path.c_str(), &status) != 0) {
        replace_or_throw(path, new_admin_token() + "\n", 0600);
        return admin_token(folder);
    }
    if ((status.st_mode & 0077U) != 0) {
        fail(path, "others than its owner may read it: chmod 600, or delete it to have a new one");
    }
    const std::string text = read_small_file(path, 4096);
    const std::string token = text.substr(0, text.find_last_not_of(" \t\r\n") + 1);
    if (!is_token(token)) {
        fail(path, "holds no 64 hexadecimal digits: delete it to have a new token");
    }
    return token;
}

void write_admin_address(const std::string& folder, const std::string& address) {
    replace_or_throw(folder + "/admin.address", address + "\n", 0644);
}

void write_admin_certificate(const std::string& folder, const std::string& certificate_file) {
    replace_or_throw(folder + "/admin.certificate",
                     read_small_file(certificate_file, kMostCertificateBytes),
                     0644);
}

}  // namespace zoned::app
