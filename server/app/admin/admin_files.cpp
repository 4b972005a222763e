#include "server/app/admin/admin_files.h"

#include "server/session/login/secrets.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
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

/// Write, sync, rename: never half a file.
void replace_file(const std::string& path, const std::string& text, mode_t mode) {
    const std::string fresh = path + ".new";
    const int fd = ::open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, mode);
    if (fd < 0) {
        fail(fresh, std::string("cannot be written: ") + std::strerror(errno));
    }
    std::size_t done = 0;
    bool good = true;
    while (good && done < text.size()) {
        const ssize_t wrote = ::write(fd, text.data() + done, text.size() - done);
        good = wrote > 0 || (wrote < 0 && errno == EINTR);
        done += wrote > 0 ? static_cast<std::size_t>(wrote) : 0;
    }
    good = good && ::fsync(fd) == 0;
    const int error = errno;
    ::close(fd);
    if (!good) {
        ::unlink(fresh.c_str());
        fail(path, std::string("cannot be written: ") + std::strerror(error));
    }
    if (std::rename(fresh.c_str(), path.c_str()) != 0) {
        fail(path, std::string("cannot be replaced: ") + std::strerror(errno));
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
    std::string out;
    for (const std::uint8_t byte : bytes) {
        out += "0123456789abcdef"[byte >> 4U];
        out += "0123456789abcdef"[byte & 15U];
    }
    return out;
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
        replace_file(path, new_admin_token() + "\n", 0600);
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
    replace_file(folder + "/admin.address", address + "\n", 0644);
}

void write_admin_certificate(const std::string& folder, const std::string& certificate_file) {
    replace_file(folder + "/admin.certificate",
                 read_small_file(certificate_file, kMostCertificateBytes),
                 0644);
}

}  // namespace zoned::app
