#include "server/config/text/sha256.h"

#include "shared/core/assert.h"
#include "shared/core/hex.h"

#include <openssl/evp.h>

namespace zoned::config {

std::string sha256_hex(std::string_view bytes) {
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned int size = 0;
    ZONED_ASSERT(EVP_Digest(bytes.data(), bytes.size(), digest, &size, EVP_sha256(), nullptr) == 1,
                 "SHA-256 is part of every OpenSSL");
    return core::to_hex({digest, size});
}

}  // namespace zoned::config
