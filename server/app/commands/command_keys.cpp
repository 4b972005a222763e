#include "server/app/commands/commands.h"
#include "server/app/runtime/key_files.h"
#include "server/mailbox/messages.h"
#include "server/session/login/ticket.h"
#include "shared/core/hex.h"

#include <fcntl.h>
#include <openssl/evp.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <ctime>
#include <span>
#include <system_error>

namespace zoned::app {

namespace {

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

std::string base64_of(std::span<const std::uint8_t> bytes) {
    std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');
    const int length = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                                       bytes.data(),
                                       static_cast<int>(bytes.size()));
    text.resize(static_cast<std::size_t>(length));
    return text;
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

int keygen(const std::string& base) {
    const session::KeyPair pair = session::generate_key_pair();
    write_new_file(base + ".key", core::to_hex(pair.private_key) + "\n", 0600);
    write_new_file(base + ".pub", core::to_hex(pair.public_key) + "\n", 0644);
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
    claims.world = arguments.world;
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
        // A line, as client-sim --ticket reads it; many of them may stand in one file.
        std::printf("%s\n", base64_of(*made).c_str());
        return kGood;
    }
    write_new_file(arguments.out, std::string(made->begin(), made->end()), 0600);
    std::printf("wrote %s\n", arguments.out.c_str());
    return kGood;
}

}  // namespace zoned::app
