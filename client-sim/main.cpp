// client-sim: bots that play on a zoned server and judge its consistency.
#include "client-sim/app/run.h"

int main(int argc, char** argv) {
    return zoned::app::client_main(argc, argv);
}
