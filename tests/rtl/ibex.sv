// Ibex with memory for `tests/cycles`: as it comes, or with PERFORMANCE the single-cycle multiplier, branch-target ALU and write-back
// stage.
module bench #(
    parameter bit PERFORMANCE = 0
) (
    input  logic        clk,
    input  logic        reset,
    input  logic [31:0] wait_states,
    output logic        ended,
    output logic [31:0] code
);
    logic [1:0] request, accepted, valid;
    logic [31:0] address [2], data [2], read [2];
    logic write;
    logic [3:0] select;
    logic [31:0] value;
    memory memory (.*);
    always_ff @(posedge clk) begin
        valid <= reset ? 0 : accepted;
        read <= data;
    end
    ibex_top #(
        .RV32M(PERFORMANCE ? ibex_pkg::RV32MSingleCycle : ibex_pkg::RV32MFast),
        .BranchTargetALU(PERFORMANCE),
        .WritebackStage(PERFORMANCE)
    ) core (
        .clk_i(clk),
        .rst_ni(!reset),
        .test_en_i(1'b0),
        .ram_cfg_i('0),
        .hart_id_i(0),
        .boot_addr_i(32'h4000_0000),
        .instr_req_o(request[0]),
        .instr_gnt_i(accepted[0]),
        .instr_rvalid_i(valid[0]),
        .instr_addr_o(address[0]),
        .instr_rdata_i(read[0]),
        .instr_rdata_intg_i('0),
        .instr_err_i(1'b0),
        .data_req_o(request[1]),
        .data_gnt_i(accepted[1]),
        .data_rvalid_i(valid[1]),
        .data_we_o(write),
        .data_be_o(select),
        .data_addr_o(address[1]),
        .data_wdata_o(value),
        .data_wdata_intg_o(),
        .data_rdata_i(read[1]),
        .data_rdata_intg_i('0),
        .data_err_i(1'b0),
        .irq_software_i(1'b0),
        .irq_timer_i(1'b0),
        .irq_external_i(1'b0),
        .irq_fast_i('0),
        .irq_nm_i(1'b0),
        .scramble_key_valid_i(1'b0),
        .scramble_key_i('0),
        .scramble_nonce_i('0),
        .scramble_req_o(),
        .debug_req_i(1'b0),
        .crash_dump_o(),
        .double_fault_seen_o(),
        .fetch_enable_i(ibex_pkg::IbexMuBiOn),
        .alert_minor_o(),
        .alert_major_internal_o(),
        .alert_major_bus_o(),
        .core_sleep_o(),
        .scan_rst_ni(1'b1)
    );
endmodule
