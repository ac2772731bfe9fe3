// VexRiscv with memory for `tests/cycles`: 4 KiB caches of instructions and data, Wishbone.
module bench (
    input  logic        clk,
    input  logic        reset,
    input  logic [31:0] wait_states,
    output logic        ended,
    output logic [31:0] code
);
    logic [1:0] cycle, strobe, accepted;
    logic [29:0] words [2];
    logic [31:0] address [2], data [2];
    logic write;
    logic [3:0] select;
    logic [31:0] value;
    assign address = '{{words[0], 2'b00}, {words[1], 2'b00}};
    memory memory (.request(cycle & strobe), .*);
    VexRiscv core (
        .clk,
        .reset,
        .externalResetVector(32'h4000_0080),
        .timerInterrupt(1'b0),
        .softwareInterrupt(1'b0),
        .externalInterruptArray('0),
        .iBusWishbone_CYC(cycle[0]),
        .iBusWishbone_STB(strobe[0]),
        .iBusWishbone_ACK(accepted[0]),
        .iBusWishbone_WE(),
        .iBusWishbone_ADR(words[0]),
        .iBusWishbone_DAT_MISO(data[0]),
        .iBusWishbone_DAT_MOSI(),
        .iBusWishbone_SEL(),
        .iBusWishbone_ERR(1'b0),
        .iBusWishbone_CTI(),
        .iBusWishbone_BTE(),
        .dBusWishbone_CYC(cycle[1]),
        .dBusWishbone_STB(strobe[1]),
        .dBusWishbone_ACK(accepted[1]),
        .dBusWishbone_WE(write),
        .dBusWishbone_ADR(words[1]),
        .dBusWishbone_DAT_MISO(data[1]),
        .dBusWishbone_DAT_MOSI(value),
        .dBusWishbone_SEL(select),
        .dBusWishbone_ERR(1'b0),
        .dBusWishbone_CTI(),
        .dBusWishbone_BTE()
    );
endmodule
