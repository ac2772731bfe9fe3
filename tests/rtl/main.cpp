// Clock and reset of a test bench: +image=FILE in the format of $readmemh, +wait=N wait states, +cycles=N at most.
#include "Vbench.h"
#include "verilated.h"
#include <cstdio>
#include <cstdlib>
#include <cstring>

static unsigned long number(const char *name) {
    const char *found = Verilated::commandArgsPlusMatch(name);
    return *found ? std::strtoul(found + 1 + std::strlen(name), nullptr, 10) : 0;
}

int main(int argc, char **argv) {
    Verilated::commandArgs(argc, argv);
    Vbench bench;
    bench.wait_states = number("wait=");
    const unsigned long most = number("cycles=");
    for (unsigned long cycle = 0; !bench.ended; cycle++) {
        if (cycle > most) {
            std::printf("error: %lu cycles and no end\n", most);
            return 3;
        }
        bench.reset = cycle >= 2 && cycle < 8; // the edge resets flip-flops without a clock
        bench.clk = 0;
        bench.eval();
        bench.clk = 1;
        bench.eval();
    }
    std::fflush(stdout);
    return static_cast<int>(bench.code);
}
