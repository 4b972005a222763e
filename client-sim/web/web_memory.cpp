// library::ClientMemory where a lack of memory stops the module: its page sees a trap.
#include "client-sim/library/client_memory.h"

namespace zoned::library {

bool ClientMemory::run(void (*work)(void*), void* argument) noexcept {
    work(argument);
    return true;
}

void ClientMemory::give_back() noexcept {
    handles_.close_all();
}

}  // namespace zoned::library
