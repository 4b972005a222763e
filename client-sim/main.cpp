// client-sim: bots that play on a zoned server and judge its consistency.
#include "client-sim/app/options.h"
#include "client-sim/app/run.h"

int main(int argc, char** argv) {
    int exit_code = 0;
    const auto options = zoned::app::parse_options(argc, argv, exit_code);
    return options ? zoned::app::run(*options) : exit_code;
}
