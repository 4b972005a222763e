// A plain driver for the targets of the fuzzers, where libFuzzer is not: runs the seeds, then
// damages them for a while. With files as arguments it runs these (a crash, a corpus) and ends.
//
//   fuzz_wire [--seconds S] [--seed K] [--write-seeds DIR] [FILE ...]
#include "tests/fuzz/fuzz.h"
#include "shared/core/rng.h"

#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

namespace zoned::fuzz {
namespace {

constexpr std::size_t kMaxBytes = 65536;

Bytes current;  // the running input, for reading after a crash

/// Calls only functions that a signal handler may call.
void on_crash(int number) {
    const int fd = ::open("fuzz-crash", O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (fd >= 0) {
        const char text[] = "the input is in the file fuzz-crash\n";
        [[maybe_unused]] ssize_t written = ::write(fd, current.data(), current.size());
        written = ::write(STDERR_FILENO, text, sizeof(text) - 1);
        ::close(fd);
    }
    std::signal(number, SIG_DFL);
    std::raise(number);
}

void run(const Bytes& input) {
    // An exact copy on the heap, so that the address sanitizer sees the first byte beyond.
    current = Bytes(input);
    current.shrink_to_fit();
    LLVMFuzzerTestOneInput(current.data(), current.size());
}

std::size_t below(core::Rng& rng, std::size_t n) {
    return rng.below(static_cast<std::uint32_t>(std::max<std::size_t>(n, 1)));
}

/// One to four changes: bits, bytes, cuts, doubled pieces, and pieces of another seed.
Bytes damaged(const std::vector<Bytes>& all, core::Rng& rng) {
    Bytes bytes = all[below(rng, all.size())];
    for (std::size_t n = 1 + below(rng, 4); n > 0; --n) {
        const std::size_t at = below(rng, bytes.size());
        const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(std::min(at, bytes.size()));
        const Bytes& other = all[below(rng, all.size())];
        const std::size_t from = below(rng, other.size());
        const std::size_t length =
            std::min(below(rng, 64), other.size() - std::min(from, other.size()));
        switch (bytes.empty() ? 2U : rng.below(6)) {
            case 0:
                bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ (1U << rng.below(8)));
                break;
            case 1:
                bytes[at] = static_cast<std::uint8_t>(rng.below(4) != 0 ? rng.below(256) : 0xFF);
                break;
            case 2:
                bytes.insert(place, static_cast<std::uint8_t>(rng.below(256)));
                break;
            case 3:
                bytes.erase(place,
                            place + static_cast<std::ptrdiff_t>(
                                        std::min(below(rng, 32), bytes.size() - at)));
                break;
            case 4:
                bytes.resize(at + 1);
                break;
            default:
                bytes.insert(place,
                             other.begin() + static_cast<std::ptrdiff_t>(from),
                             other.begin() + static_cast<std::ptrdiff_t>(from + length));
        }
    }
    bytes.resize(std::min(bytes.size(), kMaxBytes));
    return bytes;
}

int write_seeds(const std::string& folder) {
    const std::vector<Bytes> all = seeds();
    for (std::size_t i = 0; i < all.size(); ++i) {
        std::ofstream out(folder + "/seed" + std::to_string(i), std::ios::binary);
        out.write(reinterpret_cast<const char*>(all[i].data()),
                  static_cast<std::streamsize>(all[i].size()));
        if (!out) {
            std::fprintf(stderr, "cannot write to %s\n", folder.c_str());
            return 3;
        }
    }
    std::printf("%zu seeds\n", all.size());
    return 0;
}

int run_file(const char* name) {
    std::ifstream in(name, std::ios::binary);
    if (!in) {
        std::fprintf(stderr, "cannot read %s\n", name);
        return 3;
    }
    run(Bytes(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()));
    return 0;
}

int run_for(double seconds, std::uint64_t seed) {
    using Clock = std::chrono::steady_clock;
    const std::vector<Bytes> all = seeds();
    run({});
    for (const Bytes& one : all) {
        run(one);
    }
    core::Rng rng(seed);
    const auto end = Clock::now() + std::chrono::duration<double>(seconds);
    std::uint64_t runs = 0;
    for (; Clock::now() < end; ++runs) {
        run(damaged(all, rng));
    }
    std::printf("%zu seeds and %llu damaged inputs, no crash\n",
                all.size(),
                static_cast<unsigned long long>(runs));
    return 0;
}

}  // namespace
}  // namespace zoned::fuzz

int main(int argc, char** argv) {
    using namespace zoned::fuzz;
    for (const int number : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL}) {
        std::signal(number, on_crash);
    }
    double seconds = 2.0;
    std::uint64_t seed = 1;
    bool files = false;
    for (int i = 1; i < argc; ++i) {
        const bool more = i + 1 < argc;
        if (more && std::strcmp(argv[i], "--seconds") == 0) {
            seconds = std::strtod(argv[++i], nullptr);
        } else if (more && std::strcmp(argv[i], "--seed") == 0) {
            seed = std::strtoull(argv[++i], nullptr, 10);
        } else if (more && std::strcmp(argv[i], "--write-seeds") == 0) {
            return write_seeds(argv[++i]);
        } else {
            files = true;
            if (const int code = run_file(argv[i]); code != 0) {
                return code;
            }
        }
    }
    return files ? 0 : run_for(seconds, seed);
}
