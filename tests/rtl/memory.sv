// 16 MiB from 0x40000000 with two ports, and the two words of the test bench (firmware-sim/src/rt/riscv.rs). `wait_states` cycles pass
// before a request is accepted; the answer is `data` in that cycle.
module memory (
    input  logic        clk,
    input  logic [31:0] wait_states,
    input  logic [1:0]  request,
    input  logic [31:0] address [2],
    input  logic        write,         // of port 1
    input  logic [3:0]  select,
    input  logic [31:0] value,
    output logic [1:0]  accepted,
    output logic [31:0] data [2],
    output logic        ended,
    output logic [31:0] code
);
    logic [31:0] words [1 << 22];
    logic [31:0] waited [2];
    string image;
    initial begin
        if (!$value$plusargs("image=%s", image)) $fatal(1, "no +image=FILE");
        $readmemh(image, words);
    end
    for (genvar port = 0; port < 2; port++) begin : ports
        assign accepted[port] = request[port] && waited[port] >= wait_states;
        assign data[port] = words[address[port][23:2]];
        always_ff @(posedge clk) waited[port] <= request[port] && !accepted[port] ? waited[port] + 1 : 0;
    end
    always_ff @(posedge clk) begin
        if (accepted[1] && write) begin
            if (address[1][31:28] == 4'hf) begin
                if (address[1][2]) begin
                    ended <= 1;
                    code <= value;
                end else $write("%c", value[7:0]);
            end else for (int k = 0; k < 4; k++) if (select[k]) words[address[1][23:2]][8*k +: 8] <= value[8*k +: 8];
        end
        for (int port = 0; port < 2; port++)
            if (accepted[port] && address[port][31:24] != 8'h40 && !(port == 1 && address[port][31:28] == 4'hf)) begin
                $display("error: port %0d accesses %h", port, address[port]);
                ended <= 1;
                code <= 3;
            end
    end
endmodule
