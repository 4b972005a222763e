// Fuzzing of the codec of the session's messages: on any bytes it agrees with the protobuf library.
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/message_agreement.h"
#include "tests/fuzz/random_message.h"
#include "shared/core/assert.h"

#include <cstdio>

namespace zoned::fuzz {

std::vector<Bytes> seeds() {
    std::vector<Bytes> all;
    core::Rng rng(1);
    for (int i = 0; i < 40; ++i) {
        proto::ServerMessage down;
        proto::ClientMessage up;
        google::protobuf::Message& message =
            i % 4 == 0 ? static_cast<google::protobuf::Message&>(up) : down;
        test::fill_randomly(message, rng);
        const std::string bytes = message.SerializeAsString();
        all.emplace_back(bytes.begin(), bytes.end());
    }
    return all;
}

}  // namespace zoned::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string difference = zoned::test::any_disagreement({data, size});
    if (!difference.empty()) {
        std::fprintf(stderr, "%s\n", difference.c_str());
    }
    ZONED_ASSERT(difference.empty(), "codec and protobuf agree on all bytes");
    return 0;
}
