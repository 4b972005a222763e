#include "server/app/commands/commands.h"
#include "server/app/runtime/key_files.h"
#include "server/mailbox/messages.h"
#include "server/session/login/ticket.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <system_error>

namespace zoned::app {

namespace {

std::string to_hex(const std::uint8_t* bytes, std::size_t count) {
    static constexpr char kDigits[] = "0123456789abcdef";
    std::string text;
    for (std::size_t i = 0; i < count; ++i) {
        text += kDigits[bytes[i] >> 4U];
        text += kDigits[bytes[i] & 15U];
    }
    return text;
}

int hex_digit(char c) {
    if (c >= '0' && c <= '9') {
        return c - '0';
    }
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/// Never overwrites: a key that is lost cannot be made again.
void write_new_file(const std::string& path, const std::string& text, mode_t mode) {
    const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    if (fd < 0) {
        throw std::system_error(errno, std::generic_category(), "cannot create " + path);
    }
    const auto written = write(fd, text.data(), text.size());
    const bool complete = written == static_cast<ssize_t>(text.size());
    if (close(fd) != 0 || !complete) {
        throw std::system_error(EIO, std::generic_category(), "cannot write " + path);
    }
}

std::uint32_t rights_of(const std::vector<std::string>& names) {
    std::uint32_t rights = names.empty() ? mailbox::kRightPlay : 0U;
    for (const std::string& name : names) {
        rights |= name == "play"     ? mailbox::kRightPlay
                  : name == "audit"  ? mailbox::kRightAudit
                  : name == "freeze" ? mailbox::kRightFreeze
                                     : mailbox::kRightAdmin;
    }
    return rights;
}

}  // namespace

std::array<std::uint8_t, 32> read_key_file(const std::string& path) {
    std::ifstream file(path);
    std::string text;
    if (!file || !(file >> text)) {
        throw std::system_error(
            ENOENT, std::generic_category(), "cannot read the key file " + path);
    }
    std::array<std::uint8_t, 32> key{};
    bool good = text.size() == 2 * key.size();
    for (std::size_t i = 0; good && i < key.size(); ++i) {
        const int high = hex_digit(text[2 * i]);
        const int low = hex_digit(text[2 * i + 1]);
        good = high >= 0 && low >= 0;
        key[i] = static_cast<std::uint8_t>(high * 16 + low);
    }
    if (!good) {
        throw std::runtime_error(path +
                                 " holds no key: 64 lower-case hexadecimal digits are expected, as "
                                 "zoned keygen writes them");
    }
    return key;
}

int keygen(const std::string& base) {
    const session::KeyPair pair = session::generate_key_pair();
    write_new_file(
        base + ".key", to_hex(pair.private_key.data(), pair.private_key.size()) + "\n", 0600);
    write_new_file(
        base + ".pub", to_hex(pair.public_key.data(), pair.public_key.size()) + "\n", 0644);
    std::printf("wrote %s.key (keep it secret) and %s.pub (for session.ticket_public_key_file)\n",
                base.c_str(),
                base.c_str());
    return kGood;
}

int ticket(const TicketArguments& arguments) {
    session::TicketClaims claims;
    claims.account = arguments.account;
    claims.name = arguments.name.empty() ? arguments.account : arguments.name;
    claims.team = arguments.team;
    claims.rights = rights_of(arguments.rights);
    claims.not_before_s = static_cast<std::int64_t>(std::time(nullptr)) - 60;
    claims.expires_s =
        claims.not_before_s + 60 + static_cast<std::int64_t>(arguments.hours * 3600.0);
    claims.nonce = session::random_nonce();
    const auto made = session::create_ticket(claims, read_key_file(arguments.key));
    if (!made.ok()) {
        std::fprintf(stderr, "zoned: %s\n", made.error().c_str());
        return kUsage;
    }
    if (arguments.out.empty()) {
        std::printf("%s\n", to_hex(made->data(), made->size()).c_str());
        return kGood;
    }
    write_new_file(arguments.out, std::string(made->begin(), made->end()), 0600);
    std::printf("wrote %s\n", arguments.out.c_str());
    return kGood;
}

}  // namespace zoned::app
