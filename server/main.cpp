// zoned: arguments -> command -> exit code.
#include "server/app/commands/commands.h"
#include "shared/core/processor.h"

int main(int argc, char** argv) {
    zoned::core::require_processor();
    return zoned::app::run_command_line(argc, argv);
}
